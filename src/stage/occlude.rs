//! occlude: opaque, cutout and dithered casters to the opaque depth, by a minimum instead of a clip.
//!
//! In: tiles or segments of `pairs`, `footprints`. Out: `opaques` of tiles that one workgroup
//! finishes; nearness sums of the others.
use super::{
    features::{Features, Flags},
    project::CHUNK_SIZE,
    resolve,
    walk::{IN_ORDER, INVOCATION_ROWS, LANE_CASTER, SUMS, WALK, WalkKernels},
};
use crate::gpu::{Choice, KernelDesc, Tier};

pub(super) const DEPTH: Choice = Choice::new("accumulator", "accumulator/depth.wgsl");
/// State for opaque triangles only.
const TRIANGLES: Choice = Choice::new("accumulator", "accumulator/triangles.wgsl");
const TRIANGLE_LANE_CASTER: Choice = Choice::new("lane_caster", "accumulator/triangles.wgsl");
pub(super) const DEPTHS: Choice = Choice::new("output", "accumulator/depths.wgsl");

/// Opaque triangles of a few texels, written straight to `small_depths`, one element per texel of the
/// batch: views follow each other, row by row.
pub const SMALL: KernelDesc = KernelDesc {
    name: "occlude_small",
    entry: "occlude_small",
    root: "entry/small.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    tiers: &[Tier::Core],
};

pub const TILES: KernelDesc = KernelDesc {
    name: "occlude_tiles",
    entry: "walk_tile",
    root: "entry/tile.wgsl",
    with: &[IN_ORDER, DEPTH, INVOCATION_ROWS, DEPTHS, WALK, LANE_CASTER],
    constants: &[],
    tiers: Tier::BY_SUBGROUPS,
};

/// Tiles of opaque triangles only.
pub const TRIANGLE_TILES: KernelDesc = KernelDesc {
    name: "occlude_triangle_tiles",
    entry: "walk_tile",
    root: "entry/tile.wgsl",
    with: &[IN_ORDER, TRIANGLES, DEPTHS, WALK, TRIANGLE_LANE_CASTER],
    constants: &[],
    tiers: Tier::BY_SUBGROUPS,
};

pub const SEGMENTS: KernelDesc = KernelDesc {
    name: "occlude_segments",
    entry: "walk_segment",
    root: "entry/segment.wgsl",
    with: &[DEPTH, INVOCATION_ROWS, DEPTHS, WALK, LANE_CASTER, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const OVERFLOW: KernelDesc = KernelDesc {
    name: "occlude_overflow",
    entry: "scatter_overflow",
    root: "entry/overflow.wgsl",
    with: &[DEPTHS, SUMS],
    constants: &[],
    tiers: Tier::BY_ATOMICS,
};

/// Kernels for casters that block light.
pub fn kernels(features: Features) -> WalkKernels {
    WalkKernels {
        tiles: if features.has(Flags::NOT_SOLID) { &TILES } else { &TRIANGLE_TILES },
        segments: &SEGMENTS,
        overflow: &OVERFLOW,
        resolve: &resolve::OPAQUE,
    }
}
