//! Emitters and their particles as kernels read them. WGSL: `wgsl/records/emitter.wgsl`.
use crate::model::emitter::{EmittedParticle, Forces, MAX_BOXES};
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};

/// Time steps per dispatch.
pub const STEPS_AT_ONCE: u32 = 8;

/// Parameters of an emitter, and the steps to simulate.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct EmitterParams {
    pub position: Vec3,
    pub seed: u32,
    pub extent: Vec3,
    pub shape: u32,
    pub velocity: Vec3,
    pub spread: f32,
    pub wind: Vec3,
    pub drag: f32,
    pub origin: Vec3,
    pub turbulence: f32,
    pub frequency: f32,
    pub evolve: f32,
    pub gravity: f32,
    pub buoyancy: f32,
    /// Shortest lifetime [s].
    pub life_least: f32,
    /// Longest lifetime [s].
    pub life_most: f32,
    pub bounce: f32,
    pub slide: f32,
    pub ground: f32,
    pub has_ground: u32,
    pub box_count: u32,
    /// Largest number of particles that are alive at once.
    pub capacity: u32,
    /// First time step of this dispatch.
    pub step: u32,
    pub step_count: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    /// Number of particles started before each of the steps, and after the last.
    pub started: [[u32; 4]; 3],
    /// Lower and upper corners of the collision boxes [m].
    pub boxes: [Vec4; 2 * MAX_BOXES],
}
crate::gpu_layout!(EmitterParams {
    position,
    seed,
    extent,
    shape,
    velocity,
    spread,
    wind,
    drag,
    origin,
    turbulence,
    frequency,
    evolve,
    gravity,
    buoyancy,
    life_least,
    life_most,
    bounce,
    slide,
    ground,
    has_ground,
    box_count,
    capacity,
    step,
    step_count,
    pad_0,
    pad_1,
    started,
    boxes
});

impl EmitterParams {
    /// Parameters for `count` steps from `step` on, at most [`STEPS_AT_ONCE`].
    pub fn new(forces: &Forces, capacity: u32, step: u32, count: u32) -> Self {
        let count = count.min(STEPS_AT_ONCE);
        let started = |i: u32| forces.started_before(step + i.min(count));
        let mut boxes = [Vec4::ZERO; 2 * MAX_BOXES];
        for (place, corner) in boxes.iter_mut().zip(forces.boxes.iter().flatten()) {
            *place = corner.extend(0.0);
        }
        Self {
            position: forces.position,
            seed: forces.seed,
            extent: forces.extent,
            shape: forces.shape as u32,
            velocity: forces.velocity,
            spread: forces.spread,
            wind: forces.wind,
            drag: forces.drag,
            origin: forces.origin,
            turbulence: forces.turbulence,
            frequency: forces.frequency,
            evolve: forces.evolve,
            gravity: forces.gravity,
            buoyancy: forces.buoyancy,
            life_least: forces.lifetime[0],
            life_most: forces.lifetime[1],
            bounce: forces.bounce,
            slide: forces.slide,
            ground: forces.ground.unwrap_or(0.0),
            has_ground: u32::from(forces.ground.is_some()),
            box_count: forces.boxes.len().min(MAX_BOXES) as u32,
            capacity,
            step,
            step_count: count,
            pad_0: 0,
            pad_1: 0,
            started: std::array::from_fn(|row| {
                std::array::from_fn(|i| started((4 * row + i) as u32))
            }),
            boxes,
        }
    }
}

/// A particle, alive or ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GpuEmitted {
    pub position: Vec3,
    pub number: u32,
    pub velocity: Vec3,
    /// Age in the low, lifetime in the high 16 bits [steps].
    pub age_life: u32,
}
crate::gpu_layout!(GpuEmitted { position, number, velocity, age_life });

impl GpuEmitted {
    /// The particle; `None` if it has ended.
    pub fn emitted(&self) -> Option<EmittedParticle> {
        let (age, life) = (self.age_life & 0xffff, self.age_life >> 16);
        let Self { position, number, velocity, .. } = *self;
        (age < life).then_some(EmittedParticle { number, position, velocity, age, life })
    }
}
