//! resolve: sums to filter, nearest and opaque depth, for tiles that several workgroups or the scatter path
//! added to.
use super::{
    accumulate::{FILTER, KEPT_SUMS, MAPS, ORDERED_MAPS, SUMMED},
    occlude::{DEPTH, DEPTHS},
    walk::{self, INVOCATION_ROWS},
};
use crate::gpu::KernelDesc;

/// Filters of tiles that several workgroups added to.
pub const TILES: KernelDesc = walk::resolve("resolve_tiles", &[FILTER, INVOCATION_ROWS, MAPS]);

/// Replaces [`TILES`] where segments are composed one by one.
pub const ORDERED: KernelDesc = KernelDesc {
    constants: &[("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
    ..walk::resolve("resolve_ordered", &[FILTER, INVOCATION_ROWS, ORDERED_MAPS])
};

/// Replaces both where the sums themselves are kept.
pub const SUMS_ALONE: KernelDesc =
    walk::resolve("resolve_sums", &[SUMMED, INVOCATION_ROWS, KEPT_SUMS]);

/// Opaque depths of tiles that several workgroups added to.
pub const OPAQUE: KernelDesc = walk::resolve("resolve_opaque", &[DEPTH, INVOCATION_ROWS, DEPTHS]);
