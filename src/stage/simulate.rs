//! simulate: particles of emitters, moved on the device.
//!
//! In and out: `emitted`, the particles of one emitter, in a ring. `start_particles` adds the particles that
//! start in up to eight time steps, `simulate_particles` advances all by these steps. Nothing is read back: a
//! particle's slot follows from its number. `load_emitted`: in: `emitted`; out: `casters`, and a box around
//! each 256 of them.
use super::load;
use crate::gpu::{Choice, KernelDesc};

/// Particles that start in some time steps of an emitter.
pub const START: KernelDesc = KernelDesc::new("start_particles", "simulate/simulate.wgsl");

/// Some time steps of an emitter's particles.
pub const PARTICLES: KernelDesc = KernelDesc::new("simulate_particles", "simulate/simulate.wgsl");

/// Records of the live particles.
pub const CASTERS: KernelDesc = KernelDesc {
    entry: "load_casters",
    with: &[Choice::new(load::LOADER, "simulate/load_emitted.wgsl")],
    ..KernelDesc::new("load_emitted", "load/load_casters.wgsl")
};
