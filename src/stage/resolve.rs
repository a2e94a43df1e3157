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
    entry: "resolve_tile",
    with: &[FILTER, INVOCATION_ROWS, MAPS, SUMS],
    tiers: Tier::BY_ATOMICS,
    ..KernelDesc::new("resolve_tiles", "entry/resolve.wgsl")
};

/// Replaces [`TILES`] where segments are composed one by one.
pub const ORDERED: KernelDesc = KernelDesc {
    entry: "resolve_tile",
    with: &[FILTER, INVOCATION_ROWS, ORDERED_MAPS, SUMS],
    constants: &[("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
    tiers: Tier::BY_ATOMICS,
    ..KernelDesc::new("resolve_ordered", "entry/resolve.wgsl")
};

/// Replaces both where the sums themselves are kept.
pub const SUMS_ALONE: KernelDesc = KernelDesc {
    entry: "resolve_tile",
    with: &[FILTER, INVOCATION_ROWS, KEPT_SUMS, SUMS],
    tiers: Tier::BY_ATOMICS,
    ..KernelDesc::new("resolve_sums", "entry/resolve.wgsl")
};

pub const OPAQUE: KernelDesc = KernelDesc {
    entry: "resolve_tile",
    with: &[DEPTH, INVOCATION_ROWS, DEPTHS, SUMS],
    tiers: Tier::BY_ATOMICS,
    ..KernelDesc::new("resolve_opaque", "entry/resolve.wgsl")
};
