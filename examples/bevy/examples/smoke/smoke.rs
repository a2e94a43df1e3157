//! A particle effect like bevy_hanabi's: spawned, moved and read on the device alone.
#[path = "../../../common/kernel.rs"]
mod kernel;
#[path = "../../../common/particles.rs"]
mod particles;

use bevy_gobo::{
    ParticleSet,
    gobo::{
        CasterCount, CasterLoader, Error, HostCasters, Material, Shadows,
        wgpu::{self, BufferUsages},
    },
};
use kernel::{Kernel, bind};

/// Most live particles.
pub const CAPACITY: u32 = 12_000;
/// Particles born per frame.
const BORN: u32 = 200;
/// Size of a particle in `smoke.wgsl` [bytes].
const STRIDE: u64 = 48;

/// Memory layout of a particle, for the kernel that moves it, gobo's loader and the draw.
pub const STRUCT: &str = include_str!("smoke.wgsl");

pub struct Smoke {
    alive: wgpu::Buffer,
    frame: wgpu::Buffer,
    number: u32,
    kernel: Kernel,
    loader: CasterLoader,
    read: wgpu::BindGroup,
}

/// Buffer of the particles, also for their draw.
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
        let chance = include_str!("../../../common/chance.wgsl");
        let text = [STRUCT, chance, include_str!("move.wgsl")].concat();
        let kernel = Kernel::new(device, text, &[particles, &alive, &frame]);
        let layout = particles::layout(device);
        let read = bind(device, &layout, &[particles]);
        let text = format!("{STRUCT}\n{}", include_str!("load.wgsl"));
        let loader = shadows.caster_loader("load.wgsl", &text, &layout)?;
        Ok(Self { alive, frame, number: 0, kernel, loader, read })
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
        self.kernel.record(encoder, CAPACITY);
    }
}
