//! What the kernels share that walk the pairs of a tile or of a segment.
use super::{
    bin::Segment,
    hits::{CASTERS, IMAGES, MATERIALS, SETUPS, VIEWS},
};
use crate::gpu::{Binding, Source, Tier};
use wgpu::{
    TextureFormat::{Rg32Uint, Rgba32Uint},
    TextureSampleType::Uint,
};

pub(super) const TILES: Binding = Binding::texture("tiles", Uint);
pub(super) const SEGMENTS: Binding = Binding::read::<Segment>("segments");
pub(super) const DISPATCHES: Binding = Binding::read::<[u32; 4]>("dispatches");
pub(super) const PAIRS: Binding = Binding::texture_read("pairs", Rg32Uint);
pub(super) const FOOTPRINTS: Binding = Binding::texture_read("footprints", Rgba32Uint);

/// A workgroup takes a tile.
pub(super) const TILE_BINDINGS: &[Binding] =
    &[VIEWS, MATERIALS, TILES, PAIRS, FOOTPRINTS, CASTERS, SETUPS, IMAGES];
/// A workgroup takes a segment.
pub(super) const SEGMENT_BINDINGS: &[Binding] =
    &[VIEWS, MATERIALS, DISPATCHES, SEGMENTS, PAIRS, FOOTPRINTS, CASTERS, SETUPS, IMAGES];

/// Four texels in a column to an invocation.
pub(super) const LANE_SOURCES: &[Source] =
    crate::sources!["common/rows_4.wgsl", "common/lane.wgsl", "common/tile.wgsl"];
/// Eight texels in a column to an invocation.
pub(super) const TALL_LANE_SOURCES: &[Source] =
    crate::sources!["common/rows_8.wgsl", "common/lane.wgsl", "common/tile.wgsl"];

/// Visits the footprints that may touch an invocation's texels, front to back.
pub(super) const fn walk_sources(tier: Tier) -> &'static [Source] {
    match tier {
        Tier::Core => crate::sources!["common/reach.wgsl", "common/walk_uniform.wgsl"],
        Tier::Native => crate::sources!["common/reach.wgsl", "common/walk_subgroup.wgsl"],
    }
}

/// The same for opaque triangles only.
pub(super) const fn triangle_walk_sources(tier: Tier) -> &'static [Source] {
    match tier {
        Tier::Core => crate::sources!["common/walk_triangles_uniform.wgsl"],
        Tier::Native => crate::sources!["common/walk_triangles.wgsl"],
    }
}

/// The same for soft discs of the `filter` transfer only.
pub(super) const fn disc_walk_sources(tier: Tier) -> &'static [Source] {
    match tier {
        Tier::Core => crate::sources!["common/walk_discs_uniform.wgsl"],
        Tier::Native => crate::sources!["common/disc_lanes.wgsl", "common/walk_discs.wgsl"],
    }
}

/// In place of the native tier's where a software adapter has subgroups of eight lanes.
pub(super) const DISC_QUEUE_SOURCES: &[Source] =
    crate::sources!["common/disc_lanes.wgsl", "common/walk_discs_queue.wgsl"];
