//! occlude: opaque, cutout and dithered casters to the opaque depth; a minimum instead of a clip.
//!
//! In: tiles or segments of `pairs`, `footprints`. Out: `opaques` of tiles that one workgroup
//! finishes; nearness sums of the others.
use super::{
    project::CHUNK_SIZE,
    walk::{ROWS_4, ROWS_8, SUMS, WALK},
};
use crate::gpu::{Choice, KernelDesc, Tier};

const DEPTH: Choice = Choice::new("state", "state/depth.wgsl");
/// Of opaque triangles only.
const TRIANGLES: Choice = Choice::new("state", "state/triangles.wgsl");
const TRIANGLE_WALK: Choice =
    Choice::by_tier("walk", "walk/triangles_uniform.wgsl", "walk/triangles_subgroup.wgsl");

/// Opaque triangles of a few texels go straight to `small_depths`, one element per texel of the
/// batch: views follow each other, row by row.
pub const SMALL: KernelDesc = KernelDesc {
    name: "occlude_small",
    root: "driver/occlude_small.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    tiers: &[Tier::Core],
};

pub const TILES: KernelDesc = KernelDesc {
    name: "occlude_tiles",
    root: "driver/occlude_tiles.wgsl",
    with: &[ROWS_4, DEPTH, WALK],
    constants: &[],
    tiers: Tier::ALL,
};

/// Of opaque triangles only.
pub const TRIANGLE_TILES: KernelDesc = KernelDesc {
    name: "occlude_tiles",
    root: "driver/occlude_tiles.wgsl",
    with: &[ROWS_8, TRIANGLES, TRIANGLE_WALK],
    constants: &[],
    tiers: Tier::ALL,
};

pub const SEGMENTS: KernelDesc = KernelDesc {
    name: "occlude_segments",
    root: "driver/occlude_segments.wgsl",
    with: &[ROWS_4, DEPTH, WALK, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const OVERFLOW: KernelDesc = KernelDesc {
    name: "occlude_overflow",
    root: "driver/occlude_overflow.wgsl",
    with: &[SUMS],
    constants: &[],
    tiers: Tier::ALL,
};
