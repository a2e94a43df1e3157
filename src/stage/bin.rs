//! bin: from depth-sorted footprints to each tile's pairs, front to back.
//!
//! `count` adds up the pairs of each run of footprints, `scan` places the runs, `emit` writes the pairs in
//! sorted order; a stable sort by tile follows, then `tiles` finds each tile's pairs and cuts long tiles into
//! segments. Casters whose pairs do not fit are listed in `overflow` for the scatter path, or the list is
//! binned again in parts of its tiles (`src/shadows/batch/parts.rs`). `dispatches` holds the workgroup counts
//! that only the GPU knows.
use super::{sort::Partition, walk};
use crate::gpu::{Constant, KernelDesc, Tier};

/// Pairs that one workgroup of `accumulate` walks. With the loops inside a visit, an invocation
/// stays below the 65,535 iterations that llvmpipe allows it.
pub const SEGMENT_LENGTH: u32 = 2048;

/// Pairs of a segment of soft discs of the `filter` transfer, which take one iteration a pair, on software
/// adapters. It is longer, because the sums of several segments are added with atomics, which cost more than
/// a better balance saves.
pub const DISC_SEGMENT: u32 = 8192;
/// [`DISC_SEGMENT`] on GPUs, where atomics are cheap, and one subgroup would walk 8,192 pairs for a
/// millisecond or two while others idle. A tile has at most 16 million pairs; no GPU runs so many of its
/// segments at a time that their sums would wrap (2^32 / (7 * 65,536)).
pub const WIDE_DISC_SEGMENT: u32 = 1024;
/// Invocations of `scan`'s only workgroup.
const SCAN_LANES: u32 = 256;
/// Invocations of the other steps' workgroups, on software adapters: a subgroup of llvmpipe.
const SERIAL_LANES: u32 = 8;
/// Invocations of the other steps' workgroups, on GPUs. `bin_emit_wide` bisects this number.
const WIDE_LANES: &[Constant] = &[("SCAN_LANES", 64.0)];
/// Invocations of a workgroup of `clear` and `tiles`.
pub const TILE_LANES: u32 = 64;

/// Clears the counters and sums of the other kernels.
pub const CLEAR: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", TILE_LANES as f64)],
    ..KernelDesc::new("bin_clear", "bin/bin.wgsl")
};

/// Counts the pairs of each block of footprints.
pub const COUNT: KernelDesc = KernelDesc {
    with: &[walk::SCAN],
    constants: &[("SCAN_LANES", SERIAL_LANES as f64)],
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("bin_count", "bin/bin.wgsl")
};

/// Replaces [`COUNT`] on GPUs.
pub const WIDE_COUNT: KernelDesc = KernelDesc {
    with: &[walk::SCAN],
    constants: WIDE_LANES,
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("bin_count_wide", "bin/bin_wide.wgsl")
};

/// Sums the counts up to each block.
pub const SCAN: KernelDesc = KernelDesc {
    with: &[walk::SCAN],
    constants: &[("SCAN_LANES", SCAN_LANES as f64)],
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("bin_scan", "bin/bin.wgsl")
};

/// Writes the pairs.
pub const EMIT: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", SERIAL_LANES as f64)],
    ..KernelDesc::new("bin_emit", "bin/bin.wgsl")
};

/// Replaces [`EMIT`] on GPUs.
pub const WIDE_EMIT: KernelDesc = KernelDesc {
    with: &[walk::SCAN],
    constants: WIDE_LANES,
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("bin_emit_wide", "bin/bin_wide.wgsl")
};

/// First and last pair of each tile; cuts long tiles into segments.
pub const TILES: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", TILE_LANES as f64)],
    ..KernelDesc::new("bin_tiles", "bin/tiles.wgsl")
};

/// Where pairs did not fit, these bin the list again, a part of its tiles at a time.
pub const PART_CLEAR: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", TILE_LANES as f64)],
    ..KernelDesc::new("part_clear", "bin/parts.wgsl")
};

/// Where pairs did not fit: number of pairs of each tile, and the bands of tiles that each footprint may
/// touch.
pub const PART_COUNT: KernelDesc = KernelDesc::new("part_count", "bin/parts.wgsl");

/// Prefix sum of the tiles' pairs, and whether the recorded parts suffice.
pub const PART_PLAN: KernelDesc = KernelDesc::new("part_plan", "bin/parts.wgsl");

/// Before all parts: sets the numbers of segments to zero.
pub const PART_FIRST: KernelDesc = KernelDesc::new("part_first", "bin/parts.wgsl");

/// The next part: as many tiles as there is room for their pairs, and the first and last pair of each.
pub const PART_NEXT: KernelDesc = KernelDesc::new("part_next", "bin/parts.wgsl");

/// The pairs of each tile of a part, front to back.
pub const PART_GATHER: KernelDesc = KernelDesc::new("part_gather", "bin/part_gather.wgsl");

/// Entries of `dispatches`: three workgroup counts, and a number of casters or tiles. WGSL:
/// `wgsl/records/batch.wgsl`.
#[derive(Clone, Copy, Debug)]
pub enum DispatchEntry {
    /// Casters whose pairs did not fit.
    Overflow,
    /// Segments of long tiles.
    Segment,
    /// Tiles of several segments.
    Merged,
    /// [`PART_COUNT`], where footprints did not fit.
    PartCount,
    /// A workgroup for each tile of the present part; instead of a number, its first tile.
    Part,
    /// No dispatch: x is 1 if the list goes through parts; instead of a number, the tile behind
    /// the part.
    Parted,
}

impl DispatchEntry {
    /// Number of entries.
    pub const COUNT: u64 = 6;

    /// Offset in the buffer \[bytes\].
    pub fn offset(self) -> u64 {
        self as u64 * 16
    }
}

// `CLEAR` has an invocation for each of their words.
const _: () = assert!(4 * DispatchEntry::COUNT <= TILE_LANES as u64);

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/batch.wgsl`.
    #[derive(Default, Eq)]
    pub struct BinParams {
        /// For a list with host casters the most; `cull` replaces it.
        pub footprint_count: u32,
        pub run_length: u32,
        pub run_count: u32,
        pub pair_capacity: u32,
        pub tile_count: u32,
        pub view_count: u32,
        pub segment_length: u32,
        /// Runs of a workgroup.
        pub block_runs: u32,
        /// 1 for curves, whose tiles read scattered casters themselves.
        pub adds_scattered: u32,
    }
}

impl BinParams {
    /// Parameters of a list with room for `pair_capacity` pairs.
    pub fn new(
        partition: Partition,
        footprint_count: u32,
        pair_capacity: u32,
        tile_count: u32,
        view_count: u32,
        segment_length: u32,
    ) -> Self {
        let run_length = run_length(footprint_count);
        Self {
            footprint_count,
            run_length,
            run_count: footprint_count.div_ceil(run_length),
            pair_capacity,
            tile_count,
            view_count,
            segment_length,
            block_runs: block_runs(partition),
            adds_scattered: 0,
        }
    }

    /// Workgroups of the kernels that count and emit.
    pub fn run_groups(&self, partition: Partition) -> [u32; 3] {
        [self.run_count.div_ceil(block_runs(partition)), 1, 1]
    }

    /// Workgroups of [`CLEAR`], [`PART_CLEAR`] and [`TILES`].
    pub fn tile_groups(&self) -> [u32; 3] {
        [self.tile_count.div_ceil(TILE_LANES), 1, 1]
    }
}

/// Bits of the keys by which pairs are sorted.
pub fn tile_bits(tile_count: u32) -> u32 {
    (u32::BITS - tile_count.saturating_sub(1).leading_zeros()).max(1)
}

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/batch.wgsl`.
    #[derive(Default, Eq)]
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
        /// Tiles of curves that got no page.
        pub short_tiles: u32,
    }
}

/// Index of `footprint_count` among the parameters.
pub const FOOTPRINT_COUNT_INDEX: u32 = 0;

/// Index of `pair_count` among the counters.
pub const PAIR_COUNT_INDEX: u32 = 1;

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/tile.wgsl`. In a buffer they follow 16 bytes, of which the first word is their
    /// number.
    #[derive(Default, Eq)]
    pub struct Segment {
        pub tile: u32,
        pub first: u32,
        pub end: u32,
        /// Its view, and whether it is the first and the last of its tile.
        pub source: u32,
    }
}

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/batch.wgsl`.
    #[derive(Default, Eq)]
    pub struct PartParams {
        /// Most pairs of a part.
        pub room: u32,
        /// Parts that are recorded.
        pub most_parts: u32,
    }
}

/// Most pairs that an invocation's run writes. WGSL: `wgsl/records/batch.wgsl`.
pub const RUN_PAIRS: u32 = 49152;

/// Runs of a workgroup of `count` and `emit`: one for each invocation, or one for all.
pub fn block_runs(partition: Partition) -> u32 {
    match partition {
        Partition::Serial => SERIAL_LANES,
        Partition::Wide => 1,
    }
}

/// Kernels that count and emit.
pub fn count_and_emit(partition: Partition) -> [&'static KernelDesc; 2] {
    match partition {
        Partition::Serial => [&COUNT, &EMIT],
        Partition::Wide => [&WIDE_COUNT, &WIDE_EMIT],
    }
}

/// Number of runs that a list is cut into: few and long on software adapters, workgroups that keep all lanes
/// busy on GPUs.
const USUAL_RUNS: u32 = 2048;

/// Most runs of a list plus blocks of runs.
pub fn max_offsets(partition: Partition) -> u32 {
    let runs = 2 * USUAL_RUNS;
    runs + runs.div_ceil(block_runs(partition))
}

/// Length of a run \[footprints\]. With its pairs ([`RUN_PAIRS`]) it stays below llvmpipe's 65,535
/// iterations.
pub fn run_length(footprint_count: u32) -> u32 {
    footprint_count.div_ceil(USUAL_RUNS).clamp(1, 16000)
}

/// Workgroup grid for exactly `count` tiles, in as few rows as every adapter allows. A multiple of four, or
/// whole rows of one view, has such rows.
pub fn tile_grid(count: u32) -> [u32; 3] {
    const MAX_X: u32 = 65535;
    let fits = |rows: &u32| count.is_multiple_of(*rows) && count / rows <= MAX_X;
    let rows = (1..=count).find(fits).unwrap_or(1);
    [count / rows, rows, 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tile_rows_are_even_and_not_too_long() {
        for (count, rows) in
            [(0, 1), (1, 1), (65535, 1), (65536, 2), (3 * 65535, 3), (65537, 65537)]
        {
            assert_eq!(tile_grid(count), [count / rows, rows, 1], "{count}");
        }
    }

    #[test]
    fn tile_bits_hold_the_last_tile() {
        assert_eq!([0, 1, 2, 3, 4, 5, 65536].map(tile_bits), [1, 1, 1, 2, 2, 3, 16]);
    }
}
