//! The air that kernels march through.
use crate::model::Air;
use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec3};

/// Edge of a column [pixels]. WGSL: `wgsl/records/air_params.wgsl`.
pub const AIR_CELL: u32 = 4;

/// WGSL: `wgsl/records/air_params.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct AirParams {
    pub albedo: Vec3,
    /// Extinction [1/m].
    pub density: f32,
    pub anisotropy: f32,
    pub slices: u32,
    /// Samples in a slice.
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

/// Samples in a slice: the edge of a shaft that crosses it is not a step.
const SAMPLES: u32 = 2;

/// Columns of a picture.
pub fn air_columns(size: UVec2) -> UVec2 {
    (size + AIR_CELL - 1) / AIR_CELL
}
