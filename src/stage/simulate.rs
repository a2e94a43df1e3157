//! simulate: particles of emitters, moved on the device.
//!
//! In and out: `emitted`, the particles of one emitter, in a ring. `start_particles` puts those there that start
//! in up to eight time steps, `simulate_particles` advances all by these steps. Nothing is read back: a
//! particle's slot follows from its number. `load_emitted` In: `emitted`. Out: `casters`, and a box around each 256 of them.
use super::load;
use crate::gpu::{Choice, KernelDesc, Tier};

pub const START: KernelDesc = KernelDesc {
    name: "start_particles",
    entry: "start_particles",
    root: "simulate/start_particles.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const PARTICLES: KernelDesc = KernelDesc {
    name: "simulate_particles",
    entry: "simulate_particles",
    root: "simulate/simulate_particles.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const CASTERS: KernelDesc = KernelDesc {
    name: "load_emitted",
    entry: "load_casters",
    root: "load/load_casters.wgsl",
    with: &[Choice::new(load::LOADER, "simulate/load_emitted.wgsl")],
    constants: &[],
    tiers: &[Tier::Core],
};
