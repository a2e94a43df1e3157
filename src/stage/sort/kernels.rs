//! Kernels of the sort: `wgsl/sort/`.
use super::{SERIAL_CONSTANTS, WIDE_CONSTANTS};
use crate::{
    gpu::{Choice, KernelDesc, Tier},
    stage::walk::SCAN,
};

/// Values of a digit, each with a counter in a run: on software adapters, 256 of them take two seconds to
/// compile (benches/NOTES.md), 64 half a second.
const DIGITS_64: Choice = Choice::new("digits", "sort/digits_64.wgsl");
const DIGITS_256: Choice = Choice::new("digits", "sort/digits_256.wgsl");

/// How workgroups rank pairs, on GPUs.
const RANKS: Choice =
    Choice::by_tier("ranks", "sort/ranks_shared.wgsl", Tier::Subgroups, "sort/ranks_subgroup.wgsl");
/// Replaces `RANKS` where subgroups have more lanes than it reads.
pub const SHARED_RANKS: Choice = Choice::new("ranks", "sort/ranks_shared.wgsl");
pub const SERIAL_COUNT: KernelDesc = KernelDesc {
    name: "sort_serial_count",
    entry: "sort_serial_count",
    root: "sort/sort_serial_count.wgsl",
    with: &[DIGITS_64],
    constants: SERIAL_CONSTANTS,
    tiers: &[Tier::Core],
};

pub const SERIAL_SCAN: KernelDesc = KernelDesc {
    name: "sort_serial_scan",
    entry: "sort_serial_scan",
    root: "sort/sort_serial_scan.wgsl",
    with: &[],
    constants: SERIAL_CONSTANTS,
    tiers: &[Tier::Core],
};

pub const SERIAL_SCATTER: KernelDesc = KernelDesc {
    name: "sort_serial_scatter",
    entry: "sort_serial_scatter",
    root: "sort/sort_serial_scatter.wgsl",
    with: &[DIGITS_64],
    constants: SERIAL_CONSTANTS,
    tiers: &[Tier::Core],
};

pub const LONG_COUNT: KernelDesc = KernelDesc {
    name: "sort_long_count",
    entry: "sort_serial_count",
    root: "sort/sort_serial_count.wgsl",
    with: &[DIGITS_256],
    constants: SERIAL_CONSTANTS,
    tiers: &[Tier::Core],
};

pub const LONG_SCATTER: KernelDesc = KernelDesc {
    name: "sort_long_scatter",
    entry: "sort_serial_scatter",
    root: "sort/sort_serial_scatter.wgsl",
    with: &[DIGITS_256],
    constants: SERIAL_CONSTANTS,
    tiers: &[Tier::Core],
};

pub const WIDE_COUNT: KernelDesc = KernelDesc {
    name: "sort_wide_count",
    entry: "sort_wide_count",
    root: "sort/sort_wide_count.wgsl",
    with: &[],
    constants: &[],
    tiers: &[Tier::Core],
};

pub const WIDE_SCAN: KernelDesc = KernelDesc {
    name: "sort_wide_scan",
    entry: "sort_wide_scan",
    root: "sort/sort_wide_scan.wgsl",
    with: &[SCAN],
    constants: WIDE_CONSTANTS,
    tiers: Tier::BY_SUBGROUPS,
};

pub const WIDE_SCATTER: KernelDesc = KernelDesc {
    name: "sort_wide_scatter",
    entry: "sort_wide_scatter",
    root: "sort/sort_wide_scatter.wgsl",
    with: &[RANKS, SCAN],
    constants: WIDE_CONSTANTS,
    tiers: Tier::BY_SUBGROUPS,
};
