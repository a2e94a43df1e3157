//! Emitters and their particles as kernels read them. WGSL: `wgsl/records/emitter.wgsl`.
use crate::model::{
    emission::{Emission, MAX_STOPS},
    emitter::{EmittedParticle, Forces, MAX_BOXES, STEP, STEPS_PER_SECOND},
};
use glam::{Vec3, Vec4};

/// Most time steps of a dispatch.
pub const STEPS_AT_ONCE: u32 = 8;
/// Most rows of a path in a dispatch.
const PATH_ROWS: usize = 32;

crate::records::gpu_struct! {
    /// Parameters of an emitter, and the steps to simulate.
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
        /// Shortest lifetime \[s\].
        pub life_least: f32,
        /// Longest lifetime \[s\].
        pub life_most: f32,
        pub bounce: f32,
        pub slide: f32,
        /// Height; the least number for no ground \[m\].
        pub ground: f32,
        /// Time from one particle to the next \[s\].
        pub period: f32,
        pub box_count: u32,
        /// Largest number of particles alive at once.
        pub capacity: u32,
        /// First time step of this dispatch.
        pub step: u32,
        pub step_count: u32,
        /// Rows of `path`, at least 1.
        pub path_count: u32,
        /// Start of the first particle of a dispatch of one step \[s from the step\].
        pub first_birth: f32,
        /// Number of particles started before each of the steps, and after the last.
        pub started: [[u32; 4]; 3],
        /// Lower and upper corners of the collision boxes \[m\].
        pub boxes: [Vec4; 2 * MAX_BOXES],
        /// Time from the dispatch's step on \[s\], and the emitter's offset \[m\].
        pub path: [Vec4; PATH_ROWS],
    }
}

impl EmitterParams {
    /// Most steps of a dispatch. Times along a path count from the step in which a particle starts, whatever
    /// steps share a dispatch, so an emitter that moves takes its steps one by one.
    pub fn steps_at_once(forces: &Forces) -> u32 {
        if forces.path.is_empty() { STEPS_AT_ONCE } else { 1 }
    }

    /// Whether the rows of the path during one step fit.
    pub fn has_room(forces: &Forces) -> bool {
        let most = PATH_ROWS - 2;
        forces.path.windows(most + 1).all(|rows| rows[most][0] - rows[0][0] > 1.01 * STEP)
    }

    /// Parameters for `count` steps from `step` on, at most [`Self::steps_at_once`]. No particle starts from
    /// step `last` on.
    pub fn new(forces: &Forces, capacity: u32, step: u32, count: u32, last: u32) -> Self {
        let count = count.min(Self::steps_at_once(forces));
        let started = |i: u32| forces.started_before((step + i.min(count)).min(last));
        let begin = f64::from(step) / STEPS_PER_SECOND;
        let rows = forces.path_between(begin, begin + f64::from(count) / STEPS_PER_SECOND);
        let mut path = [Vec4::ZERO; PATH_ROWS];
        let path_count = rows.len().min(PATH_ROWS);
        path[..path_count].copy_from_slice(&rows[..path_count]);
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
            ground: forces.ground.unwrap_or(f32::MIN),
            period: (1.0 / forces.rate) as f32,
            box_count: forces.boxes.len().min(MAX_BOXES) as u32,
            capacity,
            step,
            step_count: count,
            path_count: path_count as u32,
            first_birth: (f64::from(started(0)) / forces.rate - begin) as f32,
            started: std::array::from_fn(|row| {
                std::array::from_fn(|i| started((4 * row + i) as u32))
            }),
            boxes,
            path,
        }
    }
}

impl EmitterParams {
    /// Number of particles that start in the steps, without those whose slot a later one takes over.
    pub(crate) fn new_count(&self, capacity: u32) -> u32 {
        let started = self.started.as_flattened();
        (started[self.step_count as usize] - started[0]).min(capacity)
    }
}

crate::records::gpu_struct! {
    /// Looks of an emitter's particles at a moment.
    pub struct EmissionParams {
        /// Number of the oldest particle that may be alive.
        pub first: u32,
        /// Slots of the ring.
        pub capacity: u32,
        pub seed: u32,
        /// Time since the last step \[steps\].
        pub part: f32,
        pub material: u32,
        pub first_id: u32,
        pub radius_count: u32,
        pub color_count: u32,
        pub alpha_count: u32,
        pub pad_0: u32,
        pub pad_1: u32,
        pub pad_2: u32,
        /// Radii at even distances over a life \[m\].
        pub radii: [[f32; 4]; MAX_STOPS / 4],
        /// Colours and alphas, each at even distances of its own.
        pub shades: [Vec4; MAX_STOPS],
    }
}

impl EmissionParams {
    /// Parameters of an emission whose particles are in a ring of `capacity` slots.
    pub fn new(emission: &Emission, capacity: u32) -> Self {
        let emitter = &*emission.emitter;
        let mut radii = [[0.0; 4]; MAX_STOPS / 4];
        radii.as_flattened_mut()[..emitter.radius.len()].copy_from_slice(&emitter.radius);
        let mut shades = [Vec4::ZERO; MAX_STOPS];
        for (shade, color) in shades.iter_mut().zip(&emitter.color) {
            *shade = color.extend(0.0);
        }
        for (shade, alpha) in shades.iter_mut().zip(&emitter.alpha) {
            shade.w = *alpha;
        }
        Self {
            first: emission.numbers().start,
            capacity,
            seed: emitter.forces.seed,
            part: emission.part,
            material: emitter.material,
            first_id: emitter.first_id,
            radius_count: emitter.radius.len() as u32,
            color_count: emitter.color.len() as u32,
            alpha_count: emitter.alpha.len() as u32,
            pad_0: 0,
            pad_1: 0,
            pad_2: 0,
            radii,
            shades,
        }
    }
}

crate::records::gpu_struct! {
    /// A particle, alive or ended.
    pub struct GpuEmitted {
        pub position: Vec3,
        pub number: u32,
        pub velocity: Vec3,
        /// Age in the low, lifetime in the high 16 bits \[steps\].
        pub age_life: u32,
    }
}

impl GpuEmitted {
    /// The particle; `None` if it has ended.
    pub fn emitted(&self) -> Option<EmittedParticle> {
        let (age, life) = (self.age_life & 0xffff, self.age_life >> 16);
        let Self { position, number, velocity, .. } = *self;
        (age < life).then_some(EmittedParticle { number, position, velocity, age, life })
    }
}
