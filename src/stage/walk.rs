//! Choices shared by all kernels that walk the pairs of a tile or a segment.
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
pub(super) const WALK: Choice = Choice::by_tier(
    "traversal",
    "traversal/uniform.wgsl",
    Tier::Subgroups,
    "traversal/subgroup.wgsl",
);
/// Sums of a batch's texels: textures where these have atomics, else buffers.
pub(super) const SUMS: Choice =
    Choice::by_tier("sums", "sums/buffers.wgsl", Tier::Native, "sums/textures.wgsl");
/// Lanes load and test any caster, and broadcast it.
pub(super) const LANE_CASTER: Choice = Choice::new("lane_caster", "traversal/lane_caster.wgsl");
/// Like [`LANE_CASTER`], with particles set up by the lanes that broadcast them.
pub(super) const FACED_LANE_CASTER: Choice =
    Choice::new("lane_caster", "traversal/lane_caster_faced.wgsl");
/// A workgroup walks the tile of its index; [`Profile`](super::profile::Profile) may replace it.
pub(super) const IN_ORDER: Choice = Choice::new("order", "entry/in_order.wgsl");
/// Texels that an invocation holds; [`Profile`](super::profile::Profile) may replace it.
pub(super) const INVOCATION_ROWS: Choice = Choice::new("rows", "traversal/rows_one.wgsl");
/// Hits that wait for late ones; [`Profile`](super::profile::Profile) may replace it.
pub(super) const WAITING: Choice = Choice::new("waiting", "hit/waiting_ring.wgsl");
