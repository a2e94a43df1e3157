//! Particle emitters simulated on the device, whose particles gobo reads as host casters.
use super::Shadows;
use crate::{
    error::{Error, Input},
    frame::{Commands, Dispatch},
    gpu::{Allocator, Kernel, Memory, Resources, Timeline, allocated, check_alive},
    model::emitter::Forces,
    records::{EmitterParams, GpuEmitted, STEPS_AT_ONCE},
    stage::{light_points::point_grid, simulate},
};
use wgpu::{Buffer, BufferUsages};

/// An emitter on the device. Its particles are those of [`Flock`](crate::model::emitter::Flock) up to
/// rounding, which turbulence and collisions amplify.
#[derive(Debug)]
pub struct Simulation {
    queue: wgpu::Queue,
    forces: Forces,
    /// Parameters for each round that one recording may make, and dispatches that start particles and advance
    /// them.
    rounds: Vec<(Buffer, [Dispatch; 2])>,
    emitted: Buffer,
    capacity: u32,
    step: u32,
    /// No particle starts from this step on.
    last: u32,
    memory: Memory,
}

/// WGSL for a [`Shadows::caster_loader`] that reads the particles of a [`Simulation`]: it goes before the
/// host's own `load_caster` and declares `emitted_particles[index]` and `life_share`. The buffer is binding 0
/// of the host's group.
pub const EMITTED_WGSL: &str = "
struct EmittedParticle { position: vec3<f32>, number: u32, velocity: vec3<f32>, age_life: u32 }
@group(1) @binding(0) var<storage, read> emitted_particles: array<EmittedParticle>;

// Age over life; 1 of a particle that has ended, which is to have no alpha.
fn life_share(particle: EmittedParticle) -> f32 {
    let life = particle.age_life >> 16u;
    return select(f32(particle.age_life & 0xffffu) / f32(max(life, 1u)), 1.0, life == 0u);
}
";

impl Shadows {
    /// An emitter that is simulated on the device, from time step 0 on.
    ///
    /// # Errors
    /// If a number of the emitter is out of its range, its path has more than 30 rows in a sixtieth of a
    /// second, or the device is lost, out of memory or refuses the kernel.
    pub fn simulation(&self, forces: &Forces) -> Result<Simulation, Error> {
        self.simulation_until(forces, u32::MAX)
    }

    /// Like [`Self::simulation`]; no particle starts from time step `last` on.
    ///
    /// # Errors
    /// Those of [`Self::simulation`].
    pub fn simulation_until(&self, forces: &Forces, last: u32) -> Result<Simulation, Error> {
        let is_crowded = || (!EmitterParams::has_room(forces)).then_some(CROWDED);
        if let Some(problem) = forces.problem().or_else(is_crowded) {
            return Err(Input::Emitter.invalid(0, problem));
        }
        let (device, _) = self.device();
        check_alive(device)?;
        allocated(device, || self.simulated(forces, last))
    }

    fn simulated(&self, forces: &Forces, last: u32) -> Result<Simulation, Error> {
        let ((device, _), queue) = (self.device(), self.queue());
        let mut memory = Memory::default();
        let mut allocator = Allocator::new(device, &mut memory);
        let capacity = forces.most_until(last).max(1);
        let copied = BufferUsages::COPY_SRC;
        let emitted = allocator.storage::<GpuEmitted>("emitted", u64::from(capacity), copied)?;
        let kernels = [self.kernel_of(&simulate::START)?, self.kernel_of(&simulate::PARTICLES)?];
        let mut rounds = Vec::new();
        for _ in 0..ROUNDS {
            let params = allocator.rewritten_uniform::<EmitterParams>("emitter_params");
            let resources =
                Resources::new().with("emitter_params", &params).with("emitted", &emitted);
            let run = |kernel: &Kernel| {
                self.kernels().dispatch_of(kernel.clone(), &resources, point_grid(capacity))
            };
            let [start, advance] = kernels.each_ref().map(run);
            rounds.push((params, [start?, advance?]));
        }
        let (queue, forces) = (queue.clone(), forces.clone());
        Ok(Simulation { queue, forces, rounds, emitted, capacity, step: 0, last, memory })
    }
}

const CROWDED: &str = "its path has too many rows in a sixtieth of a second";

/// Most rounds of one recording.
const ROUNDS: u32 = 8;

impl Simulation {
    /// Most time steps of one recording.
    pub const MAX_STEPS: u32 = ROUNDS * STEPS_AT_ONCE;

    /// Records up to `steps` more steps of 1/60 s, at most [`Self::MAX_STEPS`], and returns their number:
    /// fewer at a time if the emitter has a path. The commands must be submitted before it records again.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, steps: u32) -> u32 {
        self.record_timed(encoder, &mut Timeline::untimed(), steps)
    }

    /// Like [`Self::record`], with timestamps.
    pub fn record_timed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
        steps: u32,
    ) -> u32 {
        let end = self.step.saturating_add(steps.min(Self::MAX_STEPS));
        let (first, at_once) = (self.step, EmitterParams::steps_at_once(&self.forces));
        let mut dispatches = Vec::new();
        for (params, [start, advance]) in &self.rounds {
            let count = (end - self.step).min(at_once);
            if count == 0 {
                break;
            }
            let values =
                EmitterParams::new(&self.forces, self.capacity, self.step, count, self.last);
            self.queue.write_buffer(params, 0, bytemuck::bytes_of(&values));
            let new = values.new_count(self.capacity);
            if new > 0 {
                dispatches.push(start.with_work(point_grid(new)));
            }
            dispatches.push(advance.clone());
            self.step += count;
        }
        let mut commands = Commands::new();
        commands.pass("gobo simulate", dispatches);
        commands.record(encoder, timeline);
        self.step - first
    }

    /// Records the removal of all particles, and goes on from time step `step`, earlier or later. Particles
    /// that started before it are missing.
    pub fn restart(&mut self, encoder: &mut wgpu::CommandEncoder, step: u32) {
        encoder.clear_buffer(&self.emitted, 0, None);
        self.step = step;
    }

    /// Buffer of [`Self::capacity`] particles, for [`EMITTED_WGSL`]. Usages `STORAGE` and `COPY_SRC`.
    pub fn particles(&self) -> &Buffer {
        &self.emitted
    }

    /// Largest number of particles alive at once.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Time steps that have been recorded.
    pub fn step(&self) -> u32 {
        self.step
    }

    /// Bytes by buffer.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }
}
