//! bin, by buckets: lists with few pairs, on GPUs, without a sort by depth and by tile.
//!
//! `count` counts the pairs of each tile, `place` gives it a bucket and writes its record, `emit` fills the
//! buckets in any order, `sort` sorts each by depth key and footprint. That is the order of the stable sorts,
//! so the maps have the same bits, by four dispatches instead of sixteen.
use super::walk::SCAN;
use crate::gpu::{Choice, KernelDesc, Tier};

/// Most pairs of a list that has buckets, by its bound: those that every frame has room for.
pub const BUCKET_PAIRS: u32 = 1 << 20;
/// Most pairs of a tile, by its bound, of a list that has buckets, unless no tile had segments in the frames
/// that were counted. One workgroup sorts them; beyond 1,024 it merges.
pub const BUCKET_TILE: u32 = 8192;
/// Invocations of a workgroup of all but `sort`: footprints or tiles.
pub const BUCKET_LANES: u32 = 64;

/// Counts the pairs of each tile.
pub const COUNT: KernelDesc = KernelDesc {
    entry: "bucket_tiles",
    with: &[Choice::new("bucket", "bin/bucket_count.wgsl"), SCAN],
    constants: &[("SCAN_LANES", BUCKET_LANES as f64)],
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("bucket_count", "bin/buckets.wgsl")
};

/// A bucket for each tile; cuts long tiles into segments.
pub const PLACE: KernelDesc = KernelDesc {
    with: &[SCAN],
    constants: &[("SCAN_LANES", BUCKET_LANES as f64)],
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("bucket_place", "bin/buckets.wgsl")
};

/// Writes the pairs of each tile, in any order.
pub const EMIT: KernelDesc = KernelDesc {
    name: "bucket_emit",
    with: &[Choice::new("bucket", "bin/bucket_emit.wgsl"), SCAN],
    ..COUNT
};

/// The pairs of each tile, front to back.
pub const SORT: KernelDesc = KernelDesc::new("bucket_sort", "bin/buckets.wgsl");
