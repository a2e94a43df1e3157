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
    name: "colored_tiles",
    entry: "walk_tile",
    root: "entry/tile.wgsl",
    with: &[IN_ORDER, COLORED, INVOCATION_ROWS, COLORED_DEPTHS, WALK, LANE_CASTER],
    constants: &[],
    tiers: Tier::BY_SUBGROUPS,
};

pub const SEGMENTS: KernelDesc = KernelDesc {
    name: "colored_segments",
    entry: "walk_segment",
    root: "entry/segment.wgsl",
    with: &[COLORED, INVOCATION_ROWS, COLORED_DEPTHS, WALK, LANE_CASTER, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const OVERFLOW: KernelDesc = KernelDesc {
    name: "colored_overflow",
    entry: "scatter_overflow",
    root: "entry/overflow.wgsl",
    with: &[COLORED_DEPTHS, SUMS],
    constants: &[],
    tiers: Tier::BY_ATOMICS,
};

pub const RESOLVE: KernelDesc = KernelDesc {
    name: "colored_resolve",
    entry: "resolve_tile",
    root: "entry/resolve.wgsl",
    with: &[COLORED, INVOCATION_ROWS, COLORED_DEPTHS, SUMS],
    constants: &[],
    tiers: Tier::BY_ATOMICS,
};

/// Kernels for casters that block light, with coloured dithering.
pub const KERNELS: WalkKernels =
    WalkKernels { tiles: &TILES, segments: &SEGMENTS, overflow: &OVERFLOW, resolve: &RESOLVE };
