//! resolve: sums to filter, nearest and opaque depth, for tiles that several workgroups or the scatter path
//! added to.
use super::{
    accumulate::{FILTER, MAPS, ORDERED_MAPS},
    occlude::{DEPTH, DEPTHS},
    walk::{INVOCATION_ROWS, SUMS},
};
use crate::gpu::{Choice, KernelDesc, Tier};

const KEPT_SUMS: Choice = Choice::new("output", "accumulator/kept_sums.wgsl");

pub const TILES: KernelDesc = KernelDesc {
    name: "resolve_tiles",
    entry: "resolve_tile",
    root: "entry/resolve.wgsl",
    with: &[FILTER, INVOCATION_ROWS, MAPS, SUMS],
    constants: &[],
    tiers: Tier::BY_ATOMICS,
};

/// Replaces [`TILES`] where segments are composed one by one.
pub const ORDERED: KernelDesc = KernelDesc {
    name: "resolve_ordered",
    entry: "resolve_tile",
    root: "entry/resolve.wgsl",
    with: &[FILTER, INVOCATION_ROWS, ORDERED_MAPS, SUMS],
    constants: &[("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
    tiers: Tier::BY_ATOMICS,
};

/// Replaces both where the sums themselves are kept.
pub const SUMS_ALONE: KernelDesc = KernelDesc {
    name: "resolve_sums",
    entry: "resolve_tile",
    root: "entry/resolve.wgsl",
    with: &[FILTER, INVOCATION_ROWS, KEPT_SUMS, SUMS],
    constants: &[],
    tiers: Tier::BY_ATOMICS,
};

pub const OPAQUE: KernelDesc = KernelDesc {
    name: "resolve_opaque",
    entry: "resolve_tile",
    root: "entry/resolve.wgsl",
    with: &[DEPTH, INVOCATION_ROWS, DEPTHS, SUMS],
    constants: &[],
    tiers: Tier::BY_ATOMICS,
};
