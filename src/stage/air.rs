//! air: light that the air scatters to the eye, once, through the shadow maps: shafts, coloured
//! behind coloured glass and white before it.
//!
//! In: the shadow maps. `scatter` -> `sources`: what each slice of a column of 4x4 pixels sends to
//! the eye. `sum` -> `air`: the same from the eye on, and what is left of the light from there.
//! What is solid, and what is laid over it, takes its share at its own depth (`shade`).
use super::{
    hits::{ROLLED, VIEWS},
    shade::{LIGHT_BINDINGS, LIGHT_CONSTANTS, LIGHT_SOURCES, PARAMS},
};
use crate::{
    gpu::{Binding, Constant, FLOAT, KernelDesc, Source, Tier, join},
    model::Air,
};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::TextureFormat::Rgba32Float;

/// Edge of a column [pixels]. WGSL: `wgsl/common/air.wgsl`.
pub const AIR_CELL: u32 = 4;
/// Edge of a workgroup [columns].
pub const GROUP_SIZE: u32 = 8;

const AIR_PARAMS: Binding = Binding::uniform::<AirParams>("air_params");

pub const SCATTER: KernelDesc = KernelDesc {
    name: "air_scatter",
    sources: join![
        Source: LIGHT_SOURCES,
        crate::sources![
            "common/record.wgsl",
            "common/view.wgsl",
            "common/material.wgsl",
            "common/rolled.wgsl",
            "common/air_params.wgsl",
            "air_scatter.wgsl"
        ],
    ],
    bindings: join![
        Binding: &[VIEWS, PARAMS, AIR_PARAMS],
        LIGHT_BINDINGS,
        &[Binding::texture_write("sources", Rgba32Float).array()],
    ],
    constants: join![Constant: LIGHT_CONSTANTS, &[ROLLED]],
    tier: Tier::Core,
};

pub const SUM: KernelDesc = KernelDesc {
    name: "air_sum",
    sources: crate::sources!["common/view.wgsl", "common/air_params.wgsl", "air_sum.wgsl"],
    bindings: &[
        VIEWS,
        AIR_PARAMS,
        Binding::texture("sources", FLOAT).array(),
        Binding::texture_write("air", Rgba32Float).array(),
    ],
    constants: &[],
    tier: Tier::Core,
};

/// WGSL: `wgsl/common/air_params.wgsl`.
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
