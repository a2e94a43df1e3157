//! bin: from depth-sorted footprints to each tile's pairs, front to back.
//!
//! `count` adds up the pairs of each run of footprints, `scan` places the runs, `emit` writes the pairs in
//! sorted order; a stable sort by tile follows, then `tiles` finds each tile's pairs and cuts long tiles
//! into segments. Casters whose pairs do not fit are listed in `overflow` for the scatter path.
//! `dispatches` holds the workgroup counts that only the GPU knows.
use super::sort::Shape;
use crate::gpu::{Constant, KernelDesc, Tier};
use bytemuck::{Pod, Zeroable};

/// Pairs that one workgroup of `accumulate` walks. With the loops inside a visit, an invocation
/// stays below the 65,535 iterations that llvmpipe allows it.
pub const SEGMENT_LENGTH: u32 = 2048;

/// Pairs of a segment of soft discs of the `filter` transfer, which take one iteration a pair. It is
/// longer, because the sums of several segments are added with atomics, which cost more than a better
/// balance saves.
pub const DISC_SEGMENT: u32 = 8192;
/// Invocations of `scan`'s only workgroup.
const SCAN_LANES: u32 = 256;
/// Invocations of the other steps' workgroups, on software adapters: a subgroup of llvmpipe.
const SERIAL_LANES: u32 = 8;
/// Invocations of the other steps' workgroups, on GPUs.
const WIDE_LANES: u32 = 64;
/// Invocations of a workgroup of `tiles`.
pub const TILE_LANES: u32 = 64;

pub const COUNT: KernelDesc = KernelDesc {
    name: "bin_count",
    entry: "bin_count",
    root: "bin/bin_count.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", SERIAL_LANES as f64)],
    tiers: &[Tier::Core],
};

pub const SCAN: KernelDesc = KernelDesc {
    name: "bin_scan",
    entry: "bin_scan",
    root: "bin/bin_scan.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", SCAN_LANES as f64)],
    tiers: &[Tier::Core],
};

pub const EMIT: KernelDesc = KernelDesc {
    name: "bin_emit",
    entry: "bin_emit",
    root: "bin/bin_emit.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", SERIAL_LANES as f64)],
    tiers: &[Tier::Core],
};

pub const TILES: KernelDesc = KernelDesc {
    name: "bin_tiles",
    entry: "bin_tiles",
    root: "bin/bin_tiles.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", TILE_LANES as f64)],
    tiers: &[Tier::Core],
};

/// Entries of `dispatches`: three workgroup counts and their sum. WGSL: `wgsl/records/dispatch.wgsl`.
#[derive(Clone, Copy, Debug)]
pub enum Dispatch {
    Overflow,
    Segment,
    Merged,
}

impl Dispatch {
    pub const COUNT: u64 = 3;

    /// Offset in the buffer [bytes].
    pub fn offset(self) -> u64 {
        self as u64 * 16
    }
}

/// WGSL: `wgsl/records/bin.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct BinParams {
    pub footprint_count: u32,
    pub run_length: u32,
    pub run_count: u32,
    pub pair_capacity: u32,
    pub tile_count: u32,
    pub view_count: u32,
    pub segment_capacity: u32,
    pub segment_length: u32,
}
crate::gpu_layout!(BinParams {
    footprint_count,
    run_length,
    run_count,
    pair_capacity,
    tile_count,
    view_count,
    segment_capacity,
    segment_length
});

/// WGSL: `wgsl/records/bin.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct BatchCounters {
    pub pairs_needed: u32,
    pub pair_count: u32,
    pub visible: u32,
    pub scattered: u32,
    pub overflowed: u32,
    pub segment_count: u32,
    pub merged_count: u32,
    /// Hits out of order in a curve.
    pub disordered: u32,
}
crate::gpu_layout!(BatchCounters {
    pairs_needed,
    pair_count,
    visible,
    scattered,
    overflowed,
    segment_count,
    merged_count,
    disordered
});

/// Index of `pair_count` among the counters.
pub const PAIR_COUNT_INDEX: u32 = 1;

/// WGSL: `wgsl/records/tile.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Segment {
    pub tile: u32,
    pub first: u32,
    pub end: u32,
    pub view: u32,
}
crate::gpu_layout!(Segment { tile, first, end, view });

/// Pairs that a run writes. WGSL: `wgsl/records/bin.wgsl`.
pub const RUN_PAIRS: u32 = 49152;

/// Invocations of a workgroup of `count` and `emit`.
pub fn lanes(shape: Shape) -> u32 {
    match shape {
        Shape::Serial => SERIAL_LANES,
        Shape::Wide => WIDE_LANES,
    }
}

/// Override of [`COUNT`] and [`EMIT`].
pub fn workgroup_size(shape: Shape) -> Constant {
    ("WORKGROUP_SIZE", f64::from(lanes(shape)))
}

/// Number of runs that a list is cut into: on software adapters few and long, on GPUs enough to keep all
/// lanes busy.
fn usual_runs(shape: Shape) -> u32 {
    match shape {
        Shape::Serial => 2048,
        Shape::Wide => 65536,
    }
}

/// Most runs of a list.
pub fn max_runs(shape: Shape) -> u64 {
    2 * u64::from(usual_runs(shape))
}

/// Length of a run [footprints].
pub fn run_length(shape: Shape, footprint_count: u32) -> u32 {
    // With its pairs (`RUN_PAIRS` in WGSL) a run stays below llvmpipe's 65,535 iterations.
    const MAX_RUN: u32 = 16000;
    footprint_count.div_ceil(usual_runs(shape)).clamp(1, MAX_RUN)
}

/// Workgroup grid for exactly `count` tiles: the fewest rows that every adapter allows. A multiple of four,
/// or whole rows of one view, has such rows.
pub fn tile_grid(count: u32) -> [u32; 3] {
    const MAX_X: u32 = 65535;
    let rows = (1..=count).find(|rows| count.is_multiple_of(*rows) && count / rows <= MAX_X);
    let rows = rows.unwrap_or(1);
    [count / rows, rows, 1]
}
