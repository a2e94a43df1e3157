//! air: single scattering towards the eye through the shadow maps: shafts of light, coloured behind
//! coloured glass and white in front of it.
//!
//! In: the shadow maps, and the visible surfaces of a band. `reach` -> `air_ends`: the slices of each column
//! of 4x4 pixels that the band's pixels need, and `air_items`, a list of them. `scatter` -> `sources`: light
//! that each slice scatters to the eye. `sum` -> `air`: that light summed from the eye on, and the
//! transmittance up to there. Surfaces and layers read it at their own depth (`shade`). No later band lights
//! a slice again.
use super::kernel;
use gobo::{
    gpu::KernelDesc,
    model::MAX_AIR_STEPS,
    stage::{
        features::{Features, Flags},
        levels::{OF_AREA, OF_POINT},
    },
};

/// Edge of a block of columns, as long as a tile \[columns\]. WGSL:
/// `crates/gobo-picture/wgsl/shade/air_items.wgsl`.
pub const AIR_BLOCK: u32 = 4;
/// Slices of an item: those of a run of a block.
pub const AIR_RUN: u32 = 4;
/// Items of a block.
pub const MAX_AIR_RUNS: u32 = MAX_AIR_STEPS / AIR_RUN;
/// Words of `air_items` before the items: the workgroups of a dispatch over them, and their number.
pub const ITEM_HEAD: u32 = 4;
/// Edge of a workgroup of [`SUM`] \[columns\].
pub const SUM_SIZE: u32 = 8;

/// Slices that a band needs of each column. One workgroup per block of columns that a band sees.
pub const REACH: KernelDesc = kernel("air_reach", "shade/air_items.wgsl");

/// Light that each slice of a column scatters to the eye.
pub const SCATTER: KernelDesc =
    KernelDesc { with: &[OF_POINT], ..kernel("air_scatter", "shade/air_scatter.wgsl") };

/// [`SCATTER`] with area lights.
pub const AREA_SCATTER: KernelDesc =
    KernelDesc { name: "area_air_scatter", with: &[OF_AREA], ..SCATTER };

/// The kernel that scatters the light of a scene.
pub fn scatter(features: Features) -> &'static KernelDesc {
    if features.has(Flags::HAS_AREAS) { &AREA_SCATTER } else { &SCATTER }
}

/// Sums that light from the eye on.
pub const SUM: KernelDesc = kernel("air_sum", "shade/air_sum.wgsl");
