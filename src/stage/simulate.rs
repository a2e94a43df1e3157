//! simulate: particles of emitters, moved on the device.
//!
//! In and out: `emitted`, the particles of one emitter, in a ring. `simulate_particles` advances up to eight
//! time steps, starts the particles that begin in them, and reads nothing back: a particle's slot follows
//! from its number.
use crate::gpu::{KernelDesc, Tier};

pub const PARTICLES: KernelDesc = KernelDesc {
    name: "simulate_particles",
    entry: "simulate_particles",
    root: "simulate/simulate_particles.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};
