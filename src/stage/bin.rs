//! bin: from depth-sorted footprints to each tile's pairs, front to back.
//!
//! `count` adds up the pairs of each run of footprints, `scan` places the runs, `emit` writes the pairs in
//! sorted order; a stable sort by tile follows, then `tiles` finds each tile's pairs and cuts long tiles
//! into segments. Casters whose pairs do not fit are listed in `overflow` for the scatter path, or the list is
//! binned again in parts of its tiles (`src/shadows/parts.rs`).
//! `dispatches` holds the workgroup counts that only the GPU knows.
use super::{
    formula::{
        Formula::{
            self, Bits, Difference, Is, Least, Most, Named, Of, Quotient, QuotientUp, Rows, Sum,
        },
        Number, Numbers,
    },
    sort::Shape,
};
use crate::gpu::{KernelDesc, Tier};
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

/// [`COUNT`] for GPUs.
pub const WIDE_COUNT: KernelDesc = KernelDesc {
    name: "bin_count_wide",
    constants: &[("WORKGROUP_SIZE", WIDE_LANES as f64)],
    ..COUNT
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

/// [`EMIT`] for GPUs.
pub const WIDE_EMIT: KernelDesc = KernelDesc {
    name: "bin_emit_wide",
    constants: &[("WORKGROUP_SIZE", WIDE_LANES as f64)],
    ..EMIT
};

pub const TILES: KernelDesc = KernelDesc {
    name: "bin_tiles",
    entry: "bin_tiles",
    root: "bin/bin_tiles.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", TILE_LANES as f64)],
    tiers: &[Tier::Core],
};

/// Where pairs did not fit, these bin the list again, a part of its tiles at a time.
pub const PART_COUNT: KernelDesc = KernelDesc {
    name: "part_count",
    entry: "part_count",
    root: "bin/part_count.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const PART_PLAN: KernelDesc = KernelDesc {
    name: "part_plan",
    entry: "part_plan",
    root: "bin/part_plan.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const PART_NEXT: KernelDesc = KernelDesc {
    name: "part_next",
    entry: "part_next",
    root: "bin/part_next.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const PART_GATHER: KernelDesc = KernelDesc {
    name: "part_gather",
    entry: "part_gather",
    root: "bin/part_gather.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

/// Entries of `dispatches`: three workgroup counts and their sum. WGSL: `wgsl/records/dispatch.wgsl`.
#[derive(Clone, Copy, Debug)]
pub enum Dispatch {
    Overflow,
    Segment,
    Merged,
    PartCount,
    Part,
    Parted,
}

impl Dispatch {
    pub const COUNT: u64 = 6;

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

/// Footprints of a run. With its pairs (`RUN_PAIRS` in WGSL) it stays below llvmpipe's 65,535
/// iterations.
const RUN_LENGTH: Formula = {
    const USUAL: Formula = QuotientUp(&Of(Number::FootprintCount), &Of(Number::UsualRuns));
    Named("run_length", &Most(&Least(&USUAL, &Is(16000)), &Is(1)))
};
const RUN_COUNT: Formula =
    Named("run_count", &QuotientUp(&Of(Number::FootprintCount), &RUN_LENGTH));
/// Runs that a list has at most.
pub const MAX_RUNS: Formula = Sum(&Of(Number::UsualRuns), &Of(Number::UsualRuns));
/// Segments that a batch has at most.
pub const SEGMENT_CAPACITY: Formula = {
    const WHOLE: Formula = Quotient(&Of(Number::PairCapacity), &Is(SEGMENT_LENGTH as u64));
    Named("segment_capacity", &Sum(&WHOLE, &Of(Number::TileCount)))
};

/// Bits of the keys by which pairs are sorted.
pub const TILE_BITS: Formula = {
    const LAST: Formula = Difference(&Of(Number::TileCount), &Is(1));
    Named("tile_bits", &Most(&Bits(&LAST), &Is(1)))
};

/// Fields of [`BinParams`].
pub const PARAMS: [Formula; 8] = [
    Of(Number::FootprintCount),
    RUN_LENGTH,
    RUN_COUNT,
    Of(Number::PairCapacity),
    Of(Number::TileCount),
    Of(Number::ViewCount),
    SEGMENT_CAPACITY,
    Of(Number::SegmentLength),
];

impl BinParams {
    pub fn of(numbers: &Numbers) -> Self {
        bytemuck::cast(PARAMS.map(|field| field.count(numbers)))
    }
}

/// Workgroups of [`COUNT`] and [`EMIT`].
pub const RUN_GROUPS: [Formula; 3] = [QuotientUp(&RUN_COUNT, &Of(Number::BinLanes)), Is(1), Is(1)];
/// Workgroups of [`TILES`].
pub const TILE_GROUPS: [Formula; 3] =
    [QuotientUp(&Of(Number::TileCount), &Is(TILE_LANES as u64)), Is(1), Is(1)];
/// Workgroups for exactly as many tiles: the fewest rows that every adapter allows. A multiple of
/// four, or whole rows of one view, has such rows.
pub const TILE_GRID: [Formula; 3] = {
    const ROWS: Formula = Rows(&Of(Number::TileCount));
    [Quotient(&Of(Number::TileCount), &ROWS), ROWS, Is(1)]
};

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
    /// Overflowed footprints that went through parts of the tiles.
    pub in_parts: u32,
}
crate::gpu_layout!(BatchCounters {
    pairs_needed,
    pair_count,
    visible,
    scattered,
    overflowed,
    segment_count,
    merged_count,
    disordered,
    in_parts
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
    /// Its view, and from bit 8 the place of its tile's record in `tiles`.
    pub source: u32,
}
crate::gpu_layout!(Segment { tile, first, end, source });

/// WGSL: `wgsl/records/bin.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct PartParams {
    /// Pairs of a part at most.
    pub room: u32,
    /// Parts that are recorded.
    pub most_parts: u32,
}
crate::gpu_layout!(PartParams { room, most_parts });

/// Pairs that a run writes. WGSL: `wgsl/records/bin.wgsl`.
pub const RUN_PAIRS: u32 = 49152;

/// Invocations of a workgroup of `count` and `emit`.
pub fn lanes(shape: Shape) -> u32 {
    match shape {
        Shape::Serial => SERIAL_LANES,
        Shape::Wide => WIDE_LANES,
    }
}

/// Kernels that count and emit.
pub fn count_and_emit(shape: Shape) -> [&'static KernelDesc; 2] {
    match shape {
        Shape::Serial => [&COUNT, &EMIT],
        Shape::Wide => [&WIDE_COUNT, &WIDE_EMIT],
    }
}

/// Number of runs that a list is cut into: on software adapters few and long, on GPUs enough to keep all
/// lanes busy.
fn usual_runs(shape: Shape) -> u32 {
    match shape {
        Shape::Serial => 2048,
        Shape::Wide => 65536,
    }
}

/// Numbers of the shape's runs.
pub fn numbers(shape: Shape) -> Numbers {
    Numbers::default()
        .with(Number::BinLanes, lanes(shape))
        .with(Number::UsualRuns, usual_runs(shape))
}

/// Most runs of a list.
pub fn max_runs(shape: Shape) -> u64 {
    MAX_RUNS.of(&numbers(shape))
}

/// Length of a run [footprints].
pub fn run_length(shape: Shape, footprint_count: u32) -> u32 {
    RUN_LENGTH.count(&numbers(shape).with(Number::FootprintCount, footprint_count))
}

/// [`TILE_GRID`] for `count` tiles.
pub fn tile_grid(count: u32) -> [u32; 3] {
    let numbers = Numbers::default().with(Number::TileCount, count);
    TILE_GRID.map(|groups| groups.count(&numbers))
}
