//! gobo as a guest: the host owns device, queue and encoder, and reads the maps as textures.
//!
//! `cargo run --example embed`
use gobo::{
    Bounds, Casters, Gpu, Light, Material, Particle, ShadowSettings, Shadows,
    glam::{Vec3, Vec4},
    light_views,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Any wgpu device will do; this one is opened with the features that gobo can use.
    let gpu = Gpu::headless()?;
    let (device, queue) = (&gpu.device, &gpu.queue);

    // A row of red discs above the origin.
    let materials = [Material { tint: Vec4::new(1.0, 0.2, 0.1, 0.5), ..Material::default() }];
    let mut particles: Vec<Particle> = (0..1000_u32)
        .map(|id| Particle {
            center: Vec3::new(id as f32 * 0.002 - 1.0, 1.0, 0.0),
            id,
            ..Particle::default()
        })
        .collect();
    let sun = Light { intensity: 3.0, ..Light::directional(Vec3::NEG_Y) };
    let bounds = Bounds { min: Vec3::new(-1.2, 0.0, -1.2), max: Vec3::new(1.2, 1.5, 1.2) };
    let views = light_views(0, &sun, 512, None, &bounds)?;
    let settings = ShadowSettings::default();

    let mut shadows = Shadows::new(device, queue, &gpu.adapter)?;
    for frame in 0..3 {
        // Uploads changes, and allocates for new casters and views.
        particles[0].center.y += 0.1;
        let casters =
            Casters { particles: &particles, materials: &materials, ..Casters::default() };
        let prepared = shadows.prepare(&casters, &views, &settings)?;

        // Records only; the host submits.
        let mut encoder = device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder)?;
        queue.submit([encoder.finish()]);

        // Blocks until the device is done: a host calls this now and then, or never.
        let counters = prepared.counters()?;
        println!(
            "frame {frame}: {} pairs, maps of {:?}, {} bytes in all",
            counters.pairs,
            prepared.maps().filters.size(),
            prepared.memory().total()
        );
        shadows.grow_from(&counters);
    }
    Ok(())
}
