//! gobo on a host's own device: light of a lamp through a pane of blue smoke.
//!
//! `cargo run --example minimal`
use gobo::{
    Bounds, Casters, Light, Material, Particle, ShadowSettings, Shadows, Tier,
    host::PointBuffers,
    wgpu::{self, util::DeviceExt as _},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = ShadowSettings { size: 256, ..ShadowSettings::default() };
    let adapter = wgpu::Instance::default().request_adapter(&Default::default());
    let adapter = pollster::block_on(adapter)?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: settings.features(Tier::Core),
        required_limits: settings.limits(Tier::Core, settings.size),
        ..Default::default()
    }))?;
    let materials = [Material { tint: [0.3, 0.5, 1.0, 0.5].into(), ..Material::default() }];
    let particles = [Particle::new([0.0, 1.0, 0.0], 0.1)];
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let lights = [Light::point([0.0, 2.0, 0.0])];
    let bounds = Bounds::new([-1.0; 3], [2.0; 3]);
    let views = gobo::light_views(0, &lights[0], settings.size, None, &bounds)?;
    let mut shadows = Shadows::new(&device, &queue, &adapter.get_info())?;
    let prepared = shadows.prepare(&casters, &views, &settings)?;

    let positions = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: None,
        contents: bytemuck::cast_slice(&[[0.0_f32, 0.0, 0.0], [0.9, 0.0, 0.0]]),
        usage: wgpu::BufferUsages::STORAGE,
    });
    let points = PointBuffers { count: 2, positions: &positions, normals: None };
    let lit = prepared.light_points(&lights, &[0], &points)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder)?;
    lit.record(&mut encoder);
    queue.submit([encoder.finish()]);
    wgpu::util::DownloadBuffer::read_buffer(&device, &queue, &lit.shares().slice(..), |bytes| {
        let shares = bytes.map(|bytes| bytemuck::cast_slice(&bytes).to_vec());
        println!(
            "below the pane and beside it: {:.2?}",
            shares.unwrap_or_default() as Vec<[f32; 3]>
        );
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(())
}
