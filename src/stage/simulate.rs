//! simulate: particles that emitters send out, moved on the device.
//!
//! In and out: `flying`, the particles of one emitter, in a ring. `simulate_particles` makes up to
//! eight steps of time, starts those that begin in them, and reads nothing back: what flies stands where its
//! number says.
use crate::gpu::{KernelDesc, Tier};

pub const PARTICLES: KernelDesc = KernelDesc {
    name: "simulate_particles",
    entry: "simulate_particles",
    root: "simulate/simulate_particles.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};
