//! resolve: sums to filter, nearest and opaque depth, for the tiles that several workgroups or the
//! scatter path added to.
use super::walk::{ROWS_4, SUMS};
use crate::gpu::{KernelDesc, Tier};

pub const TILES: KernelDesc = KernelDesc {
    name: "resolve_tiles",
    root: "driver/resolve_tiles.wgsl",
    with: &[ROWS_4, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};

/// In place of [`TILES`] where segments are composed one by one.
pub const ORDERED: KernelDesc = KernelDesc {
    name: "resolve_ordered",
    root: "driver/resolve_ordered.wgsl",
    with: &[ROWS_4, SUMS],
    constants: &[("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
    tiers: Tier::ALL,
};

pub const OPAQUE: KernelDesc = KernelDesc {
    name: "resolve_opaque",
    root: "driver/resolve_opaque.wgsl",
    with: &[ROWS_4, SUMS],
    constants: &[],
    tiers: Tier::ALL,
};
