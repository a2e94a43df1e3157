//! air: light that the air scatters to the eye, once, through the shadow maps: shafts, coloured
//! behind coloured glass and white before it.
//!
//! In: the shadow maps. `scatter` -> `sources`: what each slice of a column of 4x4 pixels sends to
//! the eye. `sum` -> `air`: the same from the eye on, and what is left of the light from there.
//! What is solid, and what is laid over it, takes its share at its own depth (`shade`).
use super::levels::{OF_AREA, OF_POINT};
use crate::gpu::{KernelDesc, Tier};

/// Edge of a workgroup [columns].
pub const GROUP_SIZE: u32 = 8;

pub const SCATTER: KernelDesc = KernelDesc {
    name: "air_scatter",
    entry: "air_scatter",
    root: "shade/air_scatter.wgsl",
    with: &[OF_POINT],
    constants: &[],
    tiers: &[Tier::Core],
};

/// Where some light has a size.
pub const AREA_SCATTER: KernelDesc =
    KernelDesc { name: "area_air_scatter", with: &[OF_AREA], ..SCATTER };

pub const SUM: KernelDesc = KernelDesc {
    name: "air_sum",
    entry: "air_sum",
    root: "shade/air_sum.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};
