//! colored: coloured dithering. Each channel of a dithered caster has its own threshold and its own opaque
//! depth, so that three depths hold coloured layers in any order (McGuire and Enderton 2011). Replaces
//! `occlude`.
//!
//! In: the inputs of `occlude`. Out: `colored`, the opaque depth per channel; `opaques`, the largest of the
//! three, behind which there is no light. Softened: maps without `colored`.
use super::walk::{IN_ORDER, INVOCATION_ROWS, LANE_CASTER, SUMS, WALK, WalkKernels};
use crate::gpu::{Choice, KernelDesc, Tier};

const COLORED: Choice = Choice::new("accumulator", "accumulator/colored.wgsl");
const COLORED_DEPTHS: Choice = Choice::new("output", "accumulator/colored.wgsl");

pub const TILES: KernelDesc = KernelDesc {
    entry: "walk_tile",
    with: &[IN_ORDER, COLORED, INVOCATION_ROWS, COLORED_DEPTHS, WALK, LANE_CASTER],
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("colored_tiles", "entry/tile.wgsl")
};

pub const SEGMENTS: KernelDesc = KernelDesc {
    entry: "walk_segment",
    with: &[COLORED, INVOCATION_ROWS, COLORED_DEPTHS, WALK, LANE_CASTER, SUMS],
    tiers: Tier::ALL,
    ..KernelDesc::new("colored_segments", "entry/segment.wgsl")
};

pub const OVERFLOW: KernelDesc = KernelDesc {
    entry: "scatter_overflow",
    with: &[COLORED_DEPTHS, SUMS],
    tiers: Tier::BY_ATOMICS,
    ..KernelDesc::new("colored_overflow", "entry/overflow.wgsl")
};

pub const RESOLVE: KernelDesc = KernelDesc {
    entry: "resolve_tile",
    with: &[COLORED, INVOCATION_ROWS, COLORED_DEPTHS, SUMS],
    tiers: Tier::BY_ATOMICS,
    ..KernelDesc::new("colored_resolve", "entry/resolve.wgsl")
};

/// Kernels for casters that block light, with coloured dithering.
pub const KERNELS: WalkKernels =
    WalkKernels { tiles: &TILES, segments: &SEGMENTS, overflow: &OVERFLOW, resolve: &RESOLVE };
