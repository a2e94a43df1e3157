//! Kernels of the sort: `wgsl/sort/`.
use super::{SERIAL_CONSTANTS, WIDE_CONSTANTS};
use crate::{
    gpu::{Choice, KernelDesc, Tier},
    stage::walk::SCAN,
};

/// Values of a digit, each with a counter in a run: on software adapters, 256 counters take two seconds to
/// compile (benches/NOTES.md), 64 half a second.
const DIGITS_64: Choice = Choice::new("digits", "sort/digits_64.wgsl");
const DIGITS_256: Choice = Choice::new("digits", "sort/digits_256.wgsl");

/// Ranking of pairs by workgroups, on GPUs.
const RANKS: Choice =
    Choice::by_tier("ranks", "sort/ranks_shared.wgsl", Tier::Subgroups, "sort/ranks_subgroup.wgsl");
/// Histogram of the digits of each run. One invocation per run.
pub const SERIAL_COUNT: KernelDesc = KernelDesc {
    with: &[DIGITS_64],
    constants: SERIAL_CONSTANTS,
    ..KernelDesc::new("sort_serial_count", "sort/serial.wgsl")
};

/// Pairs with the same digit in earlier runs. One invocation per digit.
pub const SERIAL_SCAN: KernelDesc = KernelDesc {
    constants: SERIAL_CONSTANTS,
    ..KernelDesc::new("sort_serial_scan", "sort/sort.wgsl")
};

/// Moves each pair to its position by digit. One invocation per run.
pub const SERIAL_SCATTER: KernelDesc = KernelDesc {
    with: &[DIGITS_64],
    constants: SERIAL_CONSTANTS,
    ..KernelDesc::new("sort_serial_scatter", "sort/sort_serial_scatter.wgsl")
};

/// [`SERIAL_COUNT`] for digits of 256 values.
pub const LONG_COUNT: KernelDesc = KernelDesc {
    entry: "sort_serial_count",
    with: &[DIGITS_256],
    constants: SERIAL_CONSTANTS,
    ..KernelDesc::new("sort_long_count", "sort/serial.wgsl")
};

/// [`SERIAL_SCATTER`] for digits of 256 values.
pub const LONG_SCATTER: KernelDesc = KernelDesc {
    entry: "sort_serial_scatter",
    with: &[DIGITS_256],
    constants: SERIAL_CONSTANTS,
    ..KernelDesc::new("sort_long_scatter", "sort/sort_serial_scatter.wgsl")
};

/// Histogram of the digits of each block. One workgroup per block.
pub const WIDE_COUNT: KernelDesc = KernelDesc::new("sort_wide_count", "sort/wide.wgsl");

/// Pairs with the same digit in earlier blocks. One workgroup per digit.
pub const WIDE_SCAN: KernelDesc = KernelDesc {
    with: &[SCAN],
    constants: WIDE_CONSTANTS,
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("sort_wide_scan", "sort/sort_wide_scan.wgsl")
};

/// Moves each pair to its position by digit. One workgroup per block.
pub const WIDE_SCATTER: KernelDesc = KernelDesc {
    with: &[RANKS, SCAN],
    constants: WIDE_CONSTANTS,
    tiers: Tier::BY_SUBGROUPS,
    ..KernelDesc::new("sort_wide_scatter", "sort/sort_wide_scatter.wgsl")
};

/// [`WIDE_COUNT`] for [`WIDE_FEW_SCATTER`].
pub const WIDE_FEW_COUNT: KernelDesc =
    KernelDesc { name: "sort_few_count", constants: &[("FEW_BLOCKS", 1.0)], ..WIDE_COUNT };

/// Replaces [`WIDE_SCAN`] and [`WIDE_SCATTER`] where blocks are few: each sums up the others' counts.
pub const WIDE_FEW_SCATTER: KernelDesc = KernelDesc {
    name: "sort_few_scatter",
    constants: &[("SCAN_LANES", 256.0), ("FEW_BLOCKS", 1.0)],
    ..WIDE_SCATTER
};
