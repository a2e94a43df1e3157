//! accumulate and resolve of curve mode: light as a function of depth, per texel.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths, and the sums of casters whose
//! pairs did not fit. Out: `curves`, `filters` and `nearests`; segments of long tiles leave
//! `partials`, which `resolve_curve` puts together in order.
use super::{
    bin::{BatchCounters, Segment},
    hits::{CASTERS, IMAGES, MATERIALS, OPAQUES, SETUPS, VIEWS, WIDE},
    walk,
};
use crate::gpu::{Binding, KernelDesc, Tier};
use wgpu::{
    TextureFormat::{R32Float, Rg32Uint, Rgba16Float, Rgba32Uint},
    TextureSampleType::Uint,
};

/// Pairs of a segment. Longer than those of the nearest-depth mode, because each leaves a whole
/// curve; three loop iterations a pair stay below the 65,535 of llvmpipe.
pub const CURVE_SEGMENT: u32 = 8192;

/// That one segment leaves in `partials` [bytes]. `changes`: its hits may add light, or volumes
/// absorb. WGSL: `common/curve_partial.wgsl`.
pub const fn partial_bytes(nodes: u32, changes: bool) -> u64 {
    16 * 16 * (nodes as u64 / 2 + if changes { 6 } else { 1 }) * 16
}

/// Sampled where a stage has no more than 4 storage textures: loads from those are far cheaper on
/// software adapters.
const fn pairs(tier: Tier) -> Binding {
    match tier {
        Tier::Core => Binding::texture("pairs", Uint),
        Tier::Native => Binding::texture_read("pairs", Rg32Uint),
    }
}

const FOOTPRINTS: Binding = Binding::texture_read("footprints", Rgba32Uint);
const FILTERS: Binding = Binding::texture_write("filters", Rgba16Float).array();
const NEARESTS: Binding = Binding::texture_write("nearests", R32Float).array();
const CURVES: Binding = Binding::texture_write("curves", Rgba32Uint).array();

macro_rules! tiles {
    ($tier:ident, $sums:ident, $sums_file:literal, [$($walk:literal),*], [$($visit:literal),*], [$($constant:expr),*]) => {
        KernelDesc {
            name: "accumulate_curve_tiles",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/bin.wgsl",
                "common/sums.wgsl",
                $sums_file,
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/curve.wgsl",
                "common/curve_list.wgsl",
                "common/curve_volumes.wgsl",
                "common/gather_curve.wgsl",
                $($visit,)*
                $($walk,)*
                "common/overflow_curve.wgsl",
                "accumulate_curve_tiles.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                MATERIALS,
                walk::TILES,
                Binding::read::<u32>("scattered_tiles"),
                Binding::read_write::<BatchCounters>("counters"),
                FOOTPRINTS,
                pairs(Tier::$tier),
                CASTERS,
                SETUPS,
                IMAGES,
                OPAQUES,
                FILTERS,
                NEARESTS,
                CURVES
            ],
            constants: &[("NODES", 8.0), ("HAS_QUADS", 1.0), ("HAS_GAIN", 0.0), $($constant),*],
            tier: Tier::$tier,
        }
    };
}

macro_rules! segments {
    ($tier:ident, [$($walk:literal),*], [$($visit:literal),*], [$($constant:expr),*]) => {
        KernelDesc {
            name: "accumulate_curve_segments",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/bin.wgsl",
                "common/sums.wgsl",
                "common/dispatch.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/curve.wgsl",
                "common/curve_list.wgsl",
                "common/curve_volumes.wgsl",
                "common/curve_partial.wgsl",
                "common/gather_curve.wgsl",
                $($visit,)*
                $($walk,)*
                "accumulate_curve_segments.wgsl"
            ],
            bindings: &[
                VIEWS,
                MATERIALS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<Segment>("segments"),
                Binding::read_write::<[u32; 4]>("partials"),
                Binding::read_write::<BatchCounters>("counters"),
                FOOTPRINTS,
                CASTERS,
                SETUPS,
                IMAGES,
                pairs(Tier::$tier),
                OPAQUES,
            ],
            constants: &[("NODES", 8.0), ("HAS_QUADS", 1.0), ("HAS_GAIN", 0.0), $($constant),*],
            tier: Tier::$tier,
        }
    };
}

macro_rules! any {
    ($kernel:ident, $($start:tt),*) => {
        $kernel!(
            $($start),*,
            [
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/order.wgsl",
                "common/volumes.wgsl",
                "common/crossing.wgsl",
                "common/rolled.wgsl",
                "common/visit_hits.wgsl"
            ],
            [
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("HAS_OVER", 1.0),
                ("HAS_VOLUMES", 1.0),
                ("ROLLED", 0.0)
            ]
        )
    };
}

macro_rules! discs {
    ($kernel:ident, $($start:tt),*) => {
        $kernel!($($start),*, ["common/wide.wgsl", "common/disc.wgsl", "common/visit_discs.wgsl"], [("PERSPECTIVE", 0.0), ("HAS_OPAQUE", 1.0), WIDE])
    };
}

pub const TILES: [KernelDesc; 2] = [
    any!(
        tiles,
        Core,
        buffer,
        "common/sums_buffer.wgsl",
        ["common/curve_pairs_sampled.wgsl", "common/walk_slabs_uniform.wgsl"]
    ),
    any!(
        tiles,
        Native,
        texture,
        "common/sums_texture.wgsl",
        ["common/curve_pairs_stored.wgsl", "common/walk_slabs.wgsl"]
    ),
];
pub const SEGMENTS: [KernelDesc; 2] = [
    any!(segments, Core, ["common/curve_pairs_sampled.wgsl", "common/walk_slabs_uniform.wgsl"]),
    any!(segments, Native, ["common/curve_pairs_stored.wgsl", "common/walk_slabs.wgsl"]),
];
pub const DISC_TILES: [KernelDesc; 2] = [
    discs!(
        tiles,
        Core,
        buffer,
        "common/sums_buffer.wgsl",
        ["common/curve_pairs_sampled.wgsl", "common/walk_slabs_uniform.wgsl"]
    ),
    discs!(
        tiles,
        Native,
        texture,
        "common/sums_texture.wgsl",
        ["common/curve_pairs_stored.wgsl", "common/disc_lanes.wgsl", "common/walk_slab_discs.wgsl"]
    ),
];
pub const DISC_SEGMENTS: [KernelDesc; 2] = [
    discs!(segments, Core, ["common/curve_pairs_sampled.wgsl", "common/walk_slabs_uniform.wgsl"]),
    discs!(
        segments,
        Native,
        ["common/curve_pairs_stored.wgsl", "common/disc_lanes.wgsl", "common/walk_slab_discs.wgsl"]
    ),
];

macro_rules! resolve {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "resolve_curve",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/tile.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/sums.wgsl",
                $sums_file,
                "common/dispatch.wgsl",
                "common/curve.wgsl",
                "common/order.wgsl",
                "common/volumes.wgsl",
                "common/curve_list.wgsl",
                "common/curve_volumes.wgsl",
                "common/curve_partial.wgsl",
                "common/overflow_curve.wgsl",
                "resolve_curve.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<u32>("merged_tiles"),
                walk::TILES,
                Binding::read::<[u32; 4]>("partials"),
                FILTERS,
                NEARESTS,
                CURVES
            ],
            constants: &[
                ("NODES", 8.0),
                ("HAS_GAIN", 0.0),
                ("HAS_OVER", 0.0),
                ("HAS_VOLUMES", 0.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const RESOLVE: [KernelDesc; 2] = [
    resolve!(Core, buffer, "common/sums_buffer.wgsl"),
    resolve!(Native, texture, "common/sums_texture.wgsl"),
];
