//! A particle effect, as bevy_hanabi makes them: spawned, moved and read on the device alone.
use bevy_gobo::{
    ParticleSet,
    gobo::{
        CasterCount, CasterLoader, Error, HostCasters, Material, Shadows,
        wgpu::{self, BufferUsages},
    },
};

/// Particles that fly at a time.
pub const CAPACITY: u32 = 12_000;
/// In a frame.
const BORN: u32 = 200;
/// Of a particle in `smoke.wgsl` [bytes].
const STRIDE: u64 = 48;

/// How a particle lies in memory: of the kernel that moves it, of gobo's loader and of the draw.
pub const STRUCT: &str = include_str!("smoke.wgsl");

pub struct Smoke {
    alive: wgpu::Buffer,
    frame: wgpu::Buffer,
    number: u32,
    pipeline: wgpu::ComputePipeline,
    own: wgpu::BindGroup,
    loader: CasterLoader,
    read: wgpu::BindGroup,
}

/// The particles, for whoever draws them.
pub fn particles(device: &wgpu::Device) -> wgpu::Buffer {
    buffer(device, "smoke", u64::from(CAPACITY) * STRIDE, BufferUsages::STORAGE)
}

fn buffer(device: &wgpu::Device, label: &str, size: u64, usage: BufferUsages) -> wgpu::Buffer {
    let (label, mapped_at_creation) = (Some(label), false);
    device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
}

impl Smoke {
    pub fn new(
        device: &wgpu::Device,
        particles: &wgpu::Buffer,
        shadows: &mut Shadows,
    ) -> Result<Self, Error> {
        let alive = buffer(device, "alive", 4, BufferUsages::STORAGE);
        let frame = buffer(device, "frame", 16, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let text = format!("{STRUCT}\n{}", include_str!("move.wgsl"));
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("move smoke"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("move smoke"),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let own = bind(device, &pipeline.get_bind_group_layout(0), &[particles, &alive, &frame]);
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("smoke"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let read = bind(device, &layout, &[particles]);
        let text = format!("{STRUCT}\n{}", include_str!("load.wgsl"));
        let loader = shadows.caster_loader("load.wgsl", &text, &layout)?;
        Ok(Self { alive, frame, number: 0, pipeline, own, loader, read })
    }
}

impl ParticleSet for Smoke {
    fn material(&self) -> Material {
        Material::default()
    }

    fn casters<'a>(&'a self, materials: &'a [u32]) -> HostCasters<'a> {
        let count = CasterCount::Indirect { buffer: &self.alive, offset: 0, capacity: CAPACITY };
        HostCasters::new(&self.loader, &self.read, count, materials).least_alpha(0.002)
    }

    fn prepare(&mut self, queue: &wgpu::Queue) {
        let words = [self.number, BORN, CAPACITY, 0];
        queue.write_buffer(&self.frame, 0, bytemuck::cast_slice(&words));
        self.number += 1;
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.own, &[]);
        pass.dispatch_workgroups(CAPACITY.div_ceil(64), 1, 1);
    }
}

/// In order, from binding 0 on.
fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let resources = buffers.iter().map(|buffer| buffer.as_entire_binding());
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}
