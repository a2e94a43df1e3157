//! Picture of the scene from a native device, for the test in the browser: `expected WIDTH HEIGHT` prints
//! `const expected = [...]`.
#[cfg(not(target_arch = "wasm32"))]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    use gobo::{Gpu, wgpu::TextureFormat};
    use gobo_web::{Knobs, Show};
    let size = std::env::args().skip(1).map(|edge| edge.parse());
    let size: Vec<u32> = size.collect::<Result<_, _>>()?;
    let &[width, height] = &size[..] else { return Err("expected WIDTH HEIGHT".into()) };
    let gpu = Gpu::headless()?;
    let format = TextureFormat::Rgba8Unorm;
    let mut show = Show::new(&gpu.device, &gpu.queue, &gpu.adapter, format)?;
    let picture = pollster::block_on(show.picture([width, height], &Knobs::default()))?;
    gpu.check()?;
    println!("const expected = {picture:?};");
    Ok(())
}

#[cfg(target_arch = "wasm32")]
fn main() {}
