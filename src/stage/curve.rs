//! accumulate and resolve of curve mode: transmittance as a function of depth, per texel.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths, and the sums of casters whose pairs did
//! not fit. Out: `curves`, `filters` and `nearests`; segments of long tiles write `partials`, which
//! `resolve_curve` combines in order.
use super::walk::{self, IN_ORDER, INVOCATION_ROWS, LANE_CASTER, SUMS, TILE_WALK, WAITING};
use crate::gpu::{Choice, KernelDesc, Tier};

/// Size of one segment's record in `partials` \[bytes\]. `changes`: some caster adds light or is a volume.
/// WGSL: `wgsl/curve/stored.wgsl`.
pub fn partial_bytes(nodes: u32, changes: bool) -> u64 {
    16 * 16 * 16 * (u64::from(nodes / 2) + 1 + 7 * u64::from(changes))
}

/// Most segments of `length` pairs with partial results for a number of pairs: only tiles with more than one
/// segment have them.
pub fn partial_count(pair_capacity: u32, length: u32) -> u64 {
    2 * u64::from(pair_capacity / length) + 1
}

pub(super) const WALK: Choice = Choice::by_tier(
    "traversal",
    "traversal/slabs_uniform.wgsl",
    Tier::Subgroups,
    "traversal/slabs_subgroup.wgsl",
);
pub(super) const CURVES: Choice = Choice::new("accumulator", "curve/gather.wgsl");
/// Curves by two walks, for casters that only pass light on.
const RAYS: Choice = Choice::new("accumulator", "curve/ray.wgsl");
const RAY_CASTERS: Choice = Choice::new("visit", "curve/two_walks.wgsl");
/// Soft discs of the `filter` transfer only.
const RAY_DISCS: [Choice; 2] = [
    Choice::new("visit", "curve/ray_discs.wgsl"),
    Choice::new("lane_caster", "curve/ray_discs.wgsl"),
];
pub(super) const RAY_TILE: Choice = Choice::new("output", "curve/ray_tile.wgsl");
pub(super) const RAY_SEGMENT: Choice = Choice::new("output", "curve/ray_segment.wgsl");
/// Visits the nodes of tiles whose segments have curves of their own.
const RAY_RESOLVED: Choice = Choice::new("output", "curve/ray_resolve.wgsl");
/// Stores curves and maps.
const STORED: Choice = Choice::new("maps", "choices.wgsl");
/// Storage of finished nodes; [`Tuning`](super::tuning::Tuning) may replace it.
const WRITTEN: Choice = Choice::new("written", "choices.wgsl");
const TWO_WALKS: Choice = Choice::new("traversal", "curve/two_walks.wgsl");
/// One of the two walks.
const PASS: Choice =
    Choice::by_tier("pass", "traversal/uniform.wgsl", Tier::Subgroups, "traversal/subgroup.wgsl");
/// Choices of kernels that walk casters twice.
const WALKED_TWICE: &[Choice] = &[
    IN_ORDER,
    TILE_WALK,
    STORED,
    RAYS,
    RAY_CASTERS,
    WRITTEN,
    INVOCATION_ROWS,
    TWO_WALKS,
    PASS,
    LANE_CASTER,
    SUMS,
];
/// Nodes during insertion; [`Tuning`](super::tuning::Tuning) may replace it.
pub(super) const OPEN_NODES: Choice = Choice::new("nodes", "choices.wgsl");
pub(super) const TILE: Choice = Choice::new("output", "curve/tile.wgsl");
pub(super) const SEGMENT: Choice = Choice::new("output", "curve/segment.wgsl");
const RESOLVED: Choice = Choice::new("output", "curve/resolve.wgsl");

/// Choices of kernels that insert hits of any kind into curves.
pub(super) const CURVED: &[Choice] =
    &[IN_ORDER, TILE_WALK, CURVES, INVOCATION_ROWS, OPEN_NODES, WAITING, WALK, LANE_CASTER, SUMS];

/// Curves of tiles that are one segment, by insertion.
pub const TILES: KernelDesc = KernelDesc {
    shared: CURVED,
    constants: &[("NODES", 8.0), ("HAS_OVER", 1.0), ("HAS_VOLUMES", 1.0)],
    tiers: Tier::ALL,
    ..walk::tiles("accumulate_curve_tiles", &[TILE])
};

/// Curves of segments of longer tiles, by insertion.
pub const SEGMENTS: KernelDesc = KernelDesc {
    shared: CURVED,
    constants: &[("NODES", 8.0), ("HAS_OVER", 1.0), ("HAS_VOLUMES", 1.0)],
    tiers: Tier::BY_SUBGROUPS,
    ..walk::segments("accumulate_curve_segments", &[SEGMENT])
};

/// Curves of tiles that are one segment, by two walks.
pub const RAY_TILES: KernelDesc = KernelDesc {
    shared: WALKED_TWICE,
    constants: &[("NODES", 8.0)],
    tiers: Tier::ALL,
    ..walk::tiles("accumulate_curve_ray_tiles", &[RAY_TILE])
};

/// Curves of segments of longer tiles, by two walks.
pub const RAY_SEGMENTS: KernelDesc = KernelDesc {
    shared: WALKED_TWICE,
    constants: &[("NODES", 8.0)],
    tiers: Tier::BY_SUBGROUPS,
    ..walk::segments("accumulate_curve_ray_segments", &[RAY_SEGMENT])
};

/// [`RAY_TILES`] for discs alone.
pub const DISC_TILES: KernelDesc = KernelDesc {
    name: "accumulate_curve_disc_tiles",
    with: &[RAY_DISCS[0], RAY_DISCS[1], RAY_TILE],
    ..RAY_TILES
};

/// [`RAY_SEGMENTS`] for discs alone.
pub const DISC_SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_curve_disc_segments",
    with: &[RAY_DISCS[0], RAY_DISCS[1], RAY_SEGMENT],
    ..RAY_SEGMENTS
};

/// Bits of a page's column, and of its row, in its word. WGSL: `wgsl/curve/pages.wgsl`.
pub const PAGE_BITS: u32 = 10;
/// Page of tiles without a caster.
pub const BLANK_PAGE: u32 = 0;
/// Page of tiles for which there was none.
pub const SHORT_PAGE: u32 = 1;

/// Puts back the pages of views that are rendered.
pub const RELEASE_PAGES: KernelDesc = KernelDesc::new("release_pages", "curve/give_pages.wgsl");

/// Gives a page to each tile with casters.
pub const GIVE_PAGES: KernelDesc = KernelDesc::new("give_pages", "curve/give_pages.wgsl");

/// Takes them back where they do not suffice.
pub const SETTLE_PAGES: KernelDesc = KernelDesc::new("settle_pages", "curve/give_pages.wgsl");

/// Curves of tiles of several segments, by two walks.
pub const RAY_RESOLVE: KernelDesc = KernelDesc {
    shared: WALKED_TWICE,
    constants: &[("NODES", 8.0)],
    ..walk::resolve("resolve_curve_rays", &[RAY_RESOLVED])
};

/// Curves of tiles of several segments, by insertion.
pub const RESOLVE: KernelDesc = KernelDesc {
    shared: CURVED,
    constants: &[("NODES", 8.0)],
    ..walk::resolve("resolve_curve", &[RESOLVED])
};
