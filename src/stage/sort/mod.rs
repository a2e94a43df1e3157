//! sort: pairs by some bits of their key. Stable, least significant digit first.
//!
//! In: `pairs`, `counts`. Out: `pairs` or `sorted_pairs`.
//!
//! Per digit of at most 8 bits: count it per partition, scan the counts over the partitions, scatter (Merrill
//! and Grimshaw 2010, "Revisiting Sorting for GPGPU Stream Architectures": reduce, then scan. Unlike in its
//! single-pass successors, no workgroup waits for another, since WebGPU does not guarantee forward progress).
//! A partition is a *run* of one invocation or a *block* of a workgroup: see [`Partition`].
//!
//! ```text
//! pairs       (key, value) of pair i; in a texture, texel (i % 4096, i / 4096)
//! histograms  257 rows, as texels or one after another in a buffer:
//!             (p, d) = digits d in partition p, then in the partitions before p
//!             (d, 256) = digits d in all partitions
//!             of at most 256 blocks instead: (d, p) = digits d in block p
//! ```
mod kernels;

use crate::{gpu::KernelDesc, model::MAX_PAIRS};
pub use kernels::{
    LONG_COUNT, LONG_SCATTER, SERIAL_COUNT, SERIAL_SCAN, SERIAL_SCATTER, WIDE_COUNT,
    WIDE_FEW_COUNT, WIDE_FEW_SCATTER, WIDE_SCAN, WIDE_SCATTER,
};
use std::ops::Range;
use wgpu::TextureFormat::Rg32Uint;

/// Pairs in a row of a pair texture.
pub const PAIR_ROW: u32 = 4096;
// The largest texture of any known device.
const _: () = assert!(MAX_PAIRS == PAIR_ROW * 16384);
/// Format of pairs: a key and a value.
pub const PAIR_FORMAT: wgpu::TextureFormat = Rg32Uint;

/// Subgroup size of llvmpipe; more lanes would only lengthen the tail.
const SERIAL_WORKGROUP_SIZE: u32 = 8;
/// Shortest run; below it, the counters of a run cost more than its pairs \[pairs\].
const RUN_MIN: u32 = 256;
/// Usual run; longer ones are no faster \[pairs\].
const RUN_USUAL: u32 = 2048;
/// Runs that keep the cores of a software adapter busy.
const RUN_TARGET: u32 = 512;
/// Runs in a row of the histograms: WebGPU's largest texture.
const RUN_LIMIT: u32 = 8192;
const SERIAL_CONSTANTS: &[(&str, f64)] = &[
    ("WORKGROUP_SIZE", SERIAL_WORKGROUP_SIZE as f64),
    ("RUN_MIN", RUN_MIN as f64),
    ("RUN_USUAL", RUN_USUAL as f64),
    ("RUN_TARGET", RUN_TARGET as f64),
    ("RUN_LIMIT", RUN_LIMIT as f64),
];
/// Invocations of the workgroups of kernels for GPUs.
const WIDE_CONSTANTS: &[(&str, f64)] = &[("SCAN_LANES", 256.0)];

/// Bits of a digit with 64 values.
pub const FEW_BITS: u32 = 6;
/// Bits of a digit with 256 values.
pub const MAX_BITS: u32 = 8;
/// Pairs from which kernels with more counters repay their longer compilation, by fewer and faster digits. If
/// they need as many digits, from twice as many pairs \[pairs\].
const FEW_PAIRS: u32 = 1 << 19;

/// Pairs per workgroup.
pub const WIDE_BLOCK: u32 = 4096;

/// Row of the histograms that holds the totals; above it, one row per digit. WGSL:
/// `wgsl/records/record.wgsl`.
pub const TOTAL_ROW: u32 = 256;

/// Most pairs that a texture of `device` holds.
pub fn pair_limit(device: &wgpu::Device) -> u32 {
    MAX_PAIRS.min(PAIR_ROW * device.limits().max_texture_dimension_2d)
}

/// Size of a texture with a capacity of `capacity` pairs \[texels\].
pub fn pair_texture_size(capacity: u32) -> [u32; 2] {
    [PAIR_ROW, capacity.div_ceil(PAIR_ROW).max(1)]
}

crate::records::gpu_struct! {
    /// Parameters of a digit's kernels. WGSL: `wgsl/sort/sort.wgsl`.
    pub struct SortPass {
        /// Shift of the digit in the key \[bits\].
        pub shift: u32,
        /// Values of the digit: a power of two, at most 256.
        pub digit_count: u32,
        /// Capacity of both \[pairs\].
        pub capacity: u32,
        /// Index of the pair count in `counts`.
        pub count_index: u32,
    }
}

/// Partition of the work. Both partitions give the same result on every adapter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partition {
    /// Each invocation sorts a long run with counters of its own: no atomics, no barriers. For software
    /// adapters, where these are slow and parallelism is scarce.
    Serial,
    /// Each workgroup sorts a block, ranked by ballots of subgroups or, without subgroups, by bit masks in
    /// workgroup memory. For GPUs.
    Wide,
}

impl Partition {
    /// Most runs or blocks for `count` pairs or fewer. (Fewer pairs may make more runs.)
    pub fn partition_limit(self, count: u32) -> u32 {
        match self {
            Self::Serial => {
                let shortest = count.div_ceil(RUN_MIN).min(RUN_TARGET);
                shortest.max(count.div_ceil(RUN_USUAL)).min(RUN_LIMIT)
            }
            Self::Wide => count.div_ceil(WIDE_BLOCK),
        }
    }

    /// Partitions per workgroup when counting, and digits per workgroup when scanning.
    pub const fn lanes(self) -> u32 {
        match self {
            Self::Serial => SERIAL_WORKGROUP_SIZE,
            Self::Wide => 1,
        }
    }

    /// Most bits of a digit for keys with these `bits`.
    pub fn digit_bits(self, capacity: u32, bits: Range<u32>) -> u32 {
        let as_few = digits(bits.clone(), FEW_BITS).len() == digits(bits, MAX_BITS).len();
        match self {
            Self::Serial if capacity <= FEW_PAIRS || (as_few && capacity <= 2 * FEW_PAIRS) => {
                FEW_BITS
            }
            _ => MAX_BITS,
        }
    }
}

/// Most blocks that sum up each other's counts: a kilobyte each, read by each.
const FEW_BLOCKS: u32 = 256;

/// Kernels that count and scatter a digit of so many bits, in so many partitions, and the one in between that
/// scans, if any.
pub fn kernels(
    partition: Partition,
    digit_bits: u32,
    partitions: u32,
) -> (&'static KernelDesc, Option<&'static KernelDesc>, &'static KernelDesc) {
    match (partition, digit_bits) {
        (Partition::Serial, FEW_BITS) => (&SERIAL_COUNT, Some(&SERIAL_SCAN), &SERIAL_SCATTER),
        (Partition::Serial, _) => (&LONG_COUNT, Some(&SERIAL_SCAN), &LONG_SCATTER),
        (Partition::Wide, _) if partitions <= FEW_BLOCKS => {
            (&WIDE_FEW_COUNT, None, &WIDE_FEW_SCATTER)
        }
        (Partition::Wide, _) => (&WIDE_COUNT, Some(&WIDE_SCAN), &WIDE_SCATTER),
    }
}

/// Columns and rows of the histograms of `partitions` partitions.
pub fn histogram_size(partitions: u32) -> [u32; 2] {
    let width = partitions.next_multiple_of(SERIAL_WORKGROUP_SIZE).max(TOTAL_ROW);
    // Never a power of two, as in `Allocator::records`: llvmpipe would recompile.
    let is_power = width.is_power_of_two() && width < RUN_LIMIT;
    [width + SERIAL_WORKGROUP_SIZE * u32::from(is_power), TOTAL_ROW + 1]
}

/// Digits that cover `bits`: as few as possible of at most `most` bits, as even as possible, lowest first.
/// Keys have 32 bits.
pub fn digits(bits: Range<u32>, most: u32) -> impl ExactSizeIterator<Item = Range<u32>> {
    let end = bits.end.min(32);
    let start = bits.start.min(end);
    let bits = end - start;
    let digit_count = bits.div_ceil(most);
    let edge = move |digit: u32| start + bits * digit / digit_count;
    (0..digit_count).map(move |digit| edge(digit)..edge(digit + 1))
}
