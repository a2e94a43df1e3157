//! gobo as a guest: the host owns device, queue and encoder, and reads the maps as textures.
//!
//! `cargo run --example embed`
use gobo::{
    glam::{Vec3, Vec4},
    gpu::{Gpu, Timeline},
    model::{Bounds, Light, LightKind, Material, Particle},
    shadows::{CasterSet, Config, Pipeline},
    view::light_views,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Any wgpu device will do; this one is opened with the features that gobo can use.
    let gpu = Gpu::headless()?;
    let (device, queue) = (&gpu.device, &gpu.queue);

    // A row of red discs above the origin.
    let materials = [Material { tint: Vec4::new(1.0, 0.2, 0.1, 0.5), ..Material::default() }];
    let particles: Vec<Particle> = (0..1000u32)
        .map(|id| Particle {
            center: Vec3::new(id as f32 * 0.002 - 1.0, 1.0, 0.0),
            radius: 0.1,
            color: Vec4::ONE,
            rotation: 0.0,
            material: 0,
            id,
        })
        .collect();
    let sun = Light {
        name: "sun".to_owned(),
        kind: LightKind::Directional { direction: Vec3::NEG_Y },
        color: Vec3::ONE,
        intensity: 3.0,
        near: None,
        far: None,
        size: None,
        casts: true,
        cascades: None,
        shadows: Vec::new(),
        shafts: true,
    };
    let bounds = Bounds { min: Vec3::new(-1.2, 0.0, -1.2), max: Vec3::new(1.2, 1.2, 1.2) };
    let views = light_views(0, &sun, 512, None, &bounds);

    // Once, or when casters change: uploads and allocates.
    let mut pipeline = Pipeline::new(device, Config::new(gpu.tier, &gpu.adapter))?;
    let casters = CasterSet::new(device, queue, &particles, &[], &materials, &[])?;
    let prepared = pipeline.prepare(device, queue, &casters, &views, None)?;

    // Every frame: records only; the host submits.
    let mut encoder = device.create_command_encoder(&Default::default());
    prepared.record(pipeline.kernels(), &mut encoder, &mut Timeline::untimed());
    queue.submit([encoder.finish()]);

    let maps = &prepared.maps;
    println!("filters {:?}, {} bytes in all", maps.filters.size(), prepared.memory.total());
    Ok(())
}
