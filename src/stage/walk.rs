//! Entry points and choices shared by kernels of several stages.
use crate::gpu::{Choice, KernelDesc, Tier};

/// Kernels that walk the pairs of a list of casters.
#[derive(Clone, Copy, Debug)]
pub struct WalkKernels {
    /// Tiles that are one segment.
    pub tiles: &'static KernelDesc,
    /// Segments of longer tiles.
    pub segments: &'static KernelDesc,
    /// Casters whose pairs did not fit.
    pub overflow: &'static KernelDesc,
    /// Tiles that several workgroups added to.
    pub resolve: &'static KernelDesc,
}

/// Visits the footprints that may touch an invocation's texels, front to back.
pub const WALK: Choice = Choice::by_tier(
    "traversal",
    "traversal/uniform.wgsl",
    Tier::Subgroups,
    "traversal/subgroup.wgsl",
);
/// Sums of a batch's texels: textures where these have atomics, else a buffer;
/// [`Tuning`](super::tuning::Tuning) may replace it.
pub(super) const SUMS: Choice =
    Choice::by_tier("sums", "sums/by_texel.wgsl", Tier::Native, "sums/textures.wgsl");
/// Prefix sums of a workgroup.
pub(super) const SCAN: Choice =
    Choice::by_tier("scan", "scan/prefix.wgsl", Tier::Subgroups, "scan/prefix_subgroup.wgsl");
/// Lanes load and test casters of any kind, and broadcast them.
pub const LANE_CASTER: Choice = Choice::new("lane_caster", "traversal/lane_caster.wgsl");
/// Maps a workgroup to the tile of its index; [`Tuning`](super::tuning::Tuning) may replace it.
pub const IN_ORDER: Choice = Choice::new("order", "choices.wgsl");
/// Tiles of a workgroup; [`Tuning`](super::tuning::Tuning) may replace it.
pub(super) const TILE_WALK: Choice = Choice::new("tiles", "choices.wgsl");
/// Texels that an invocation holds; [`Tuning`](super::tuning::Tuning) may replace it.
pub(super) const INVOCATION_ROWS: Choice = Choice::new("rows", "choices.wgsl");
/// Texels that an invocation holds where all casters are of one simple kind;
/// [`Tuning`](super::tuning::Tuning) may replace it.
const COLUMN: Choice = Choice::new("column", "choices.wgsl");
/// Hits that wait for late ones; [`Tuning`](super::tuning::Tuning) may replace it.
pub(super) const WAITING: Choice = Choice::new("waiting", "hit/waiting_ring.wgsl");

/// Choices of kernels that walk casters of any kind.
const WALKED: &[Choice] = &[IN_ORDER, TILE_WALK, COLUMN, WAITING, WALK, LANE_CASTER, SUMS];

/// Walks a tile that is one segment.
pub(super) const fn tiles(name: &'static str, with: &'static [Choice]) -> KernelDesc {
    walk(name, with, Tier::BY_SUBGROUPS, "walk_tile", "entry/walk.wgsl")
}

/// Walks a segment of a longer tile.
pub(super) const fn segments(name: &'static str, with: &'static [Choice]) -> KernelDesc {
    walk(name, with, Tier::ALL, "walk_segment", "entry/walk.wgsl")
}

/// Scatters casters whose pairs did not fit.
pub(super) const fn overflow(name: &'static str, with: &'static [Choice]) -> KernelDesc {
    walk(name, with, Tier::BY_ATOMICS, "scatter_overflow", "entry/walk.wgsl")
}

/// Makes the maps of a tile that several workgroups added to.
pub(super) const fn resolve(name: &'static str, with: &'static [Choice]) -> KernelDesc {
    walk(name, with, Tier::BY_ATOMICS, "resolve_tile", "entry/walk.wgsl")
}

const fn walk(
    name: &'static str,
    with: &'static [Choice],
    tiers: &'static [Tier],
    entry: &'static str,
    root: &'static str,
) -> KernelDesc {
    KernelDesc { name, with, tiers, shared: WALKED, ..KernelDesc::new(entry, root) }
}
