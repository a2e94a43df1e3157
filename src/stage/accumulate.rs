//! accumulate: front to back through each tile's pairs, in registers.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths. Out: `filters` and `nearests` of
//! tiles that one workgroup finishes; sums of the others, of tiny particles and of overflow.
use super::{
    project::CHUNK_SIZE,
    walk::{ROWS_4, ROWS_8, SUMS, WALK},
};
use crate::gpu::{Choice, KernelDesc, Tier};

/// Workgroups of `tiny`: 8,192 invocations in flight, each adding at most 7 * 65,536 to a texel,
/// stay below 2^32.
pub const TINY_GROUPS: u32 = 32;

/// Light of four texels.
const FILTER: Choice = Choice::new("state", "state/filter.wgsl");
/// Light of eight texels, of soft discs of the `filter` transfer only.
const DISCS: Choice = Choice::new("state", "state/discs.wgsl");
const DISC_WALK: Choice =
    Choice::by_tier("walk", "walk/discs_uniform.wgsl", "walk/discs_subgroup.wgsl");
/// In place of it where discs wait in a queue.
const QUEUE_WALK: Choice = Choice::new("walk", "llvmpipe/disc_queue.wgsl");
const MAPS: Choice = Choice::new("maps", "driver/maps.wgsl");
const FETCHED_MAPS: Choice = Choice::new("maps", "llvmpipe/maps_fetched.wgsl");

pub const TILES: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    root: "driver/accumulate_tiles.wgsl",
    with: &[ROWS_4, FILTER, WALK, MAPS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    root: "driver/accumulate_segments.wgsl",
    with: &[ROWS_4, FILTER, WALK, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

/// In place of [`SEGMENTS`] where segments are composed one by one.
pub const ORDERED: KernelDesc = KernelDesc {
    name: "accumulate_ordered",
    root: "driver/accumulate_ordered.wgsl",
    with: &[ROWS_4, FILTER, WALK, SUMS],
    constants: &[("HAS_OVER", 1.0), ("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
    tiers: Tier::ALL,
};

pub const TINY: KernelDesc = KernelDesc {
    name: "accumulate_tiny",
    root: "driver/accumulate_tiny.wgsl",
    with: &[SUMS],
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    tiers: Tier::ALL,
};

pub const OVERFLOW: KernelDesc = KernelDesc {
    name: "accumulate_overflow",
    root: "driver/accumulate_overflow.wgsl",
    with: &[SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

pub const DISC_TILES: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    root: "driver/accumulate_tiles.wgsl",
    with: &[ROWS_8, DISCS, DISC_WALK, MAPS],
    constants: &[],
    tiers: Tier::ALL,
};

/// In place of [`DISC_TILES`] where discs wait in a queue.
pub const DISC_QUEUE_TILES: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    root: "driver/accumulate_tiles.wgsl",
    with: &[ROWS_8, DISCS, QUEUE_WALK, FETCHED_MAPS],
    constants: &[],
    tiers: &[Tier::Native],
};

pub const DISC_SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    root: "driver/accumulate_segments.wgsl",
    with: &[ROWS_8, DISCS, DISC_WALK, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

/// In place of [`DISC_SEGMENTS`] where discs wait in a queue.
pub const DISC_QUEUE_SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    root: "driver/accumulate_segments.wgsl",
    with: &[ROWS_8, DISCS, QUEUE_WALK, SUMS],
    constants: &[],
    tiers: &[Tier::Native],
};
