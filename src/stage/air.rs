//! air: light that the air scatters to the eye, once, through the shadow maps: shafts, coloured
//! behind coloured glass and white before it.
//!
//! In: the shadow maps. `scatter` -> `sources`: what each slice of a column of 4x4 pixels sends to
//! the eye. `sum` -> `air`: the same from the eye on, and what is left of the light from there.
//! What is solid, and what is laid over it, takes its share at its own depth (`shade`).
use crate::{
    gpu::{KernelDesc, Tier},
    model::Air,
};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Edge of a column [pixels]. WGSL: `wgsl/records/air_params.wgsl`.
pub const AIR_CELL: u32 = 4;
/// Edge of a workgroup [columns].
pub const GROUP_SIZE: u32 = 8;

pub const SCATTER: KernelDesc = KernelDesc {
    name: "air_scatter",
    root: "shade/air_scatter.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const SUM: KernelDesc = KernelDesc {
    name: "air_sum",
    root: "shade/air_sum.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

/// WGSL: `wgsl/records/air_params.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct AirParams {
    pub albedo: Vec3,
    /// Extinction [1/m].
    pub density: f32,
    pub anisotropy: f32,
    pub slices: u32,
    /// Of a slice.
    pub samples: u32,
    pub pad_0: u32,
}
crate::gpu_layout!(AirParams { albedo, density, anisotropy, slices, samples, pad_0 });

impl AirParams {
    pub fn new(air: &Air) -> Self {
        Self {
            albedo: air.albedo,
            density: air.density,
            anisotropy: air.anisotropy,
            slices: air.steps,
            samples: SAMPLES,
            pad_0: 0,
        }
    }
}

/// Of a slice: the edge of a shaft that crosses it is not a step.
const SAMPLES: u32 = 2;
