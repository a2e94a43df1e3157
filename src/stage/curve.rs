//! accumulate and resolve of curve mode: light as a function of depth, per texel.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths, and the sums of casters whose
//! pairs did not fit. Out: `curves`, `filters` and `nearests`; segments of long tiles leave
//! `partials`, which `resolve_curve` puts together in order.
use super::{
    bin::BatchCounters,
    hits::{
        CASTER_SOURCES, CASTERS, HIT_CONSTANTS, HIT_SOURCES, IMAGES, MATERIALS, OPAQUES, SETUPS,
        VIEWS, WIDE,
    },
    sums::{RESOLVE_BINDINGS, RESOLVE_SOURCES, sums, sums_sources},
    walk::{DISPATCHES, FOOTPRINTS, LANE_SOURCES, SEGMENTS as SEGMENT_LIST, TILES as TILE_LIST},
};
use crate::gpu::{Binding, Constant, KernelDesc, Source, Tier, join, on_each_tier};
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

const CURVE_SOURCES: &[Source] = join![
    Source: LANE_SOURCES,
    crate::sources![
        "common/bin.wgsl",
        "common/reach.wgsl",
        "common/curve.wgsl",
        "common/light4.wgsl",
        "common/curve_list.wgsl",
        "common/curve_volumes.wgsl",
        "common/key_depths.wgsl",
        "common/gather_curve.wgsl"
    ],
];
const HIT_VISIT_SOURCES: &[Source] = join![
    Source: HIT_SOURCES,
    CURVE_SOURCES,
    crate::sources![
        "common/order.wgsl",
        "common/volumes.wgsl",
        "common/crossing.wgsl",
        "common/hit_order.wgsl",
        "common/visit_hits.wgsl"
    ],
];
const DISC_VISIT_SOURCES: &[Source] = join![
    Source: CASTER_SOURCES,
    CURVE_SOURCES,
    crate::sources!["common/wide.wgsl", "common/disc.wgsl", "common/visit_discs.wgsl"],
];
const TILE_SOURCES: &[Source] =
    crate::sources!["common/overflow_curve.wgsl", "accumulate_curve_tiles.wgsl"];
const SEGMENT_SOURCES: &[Source] = crate::sources![
    "common/sums.wgsl",
    "common/dispatch.wgsl",
    "common/curve_partial.wgsl",
    "accumulate_curve_segments.wgsl"
];

const fn walk_sources(tier: Tier) -> &'static [Source] {
    match tier {
        Tier::Core => {
            crate::sources!["common/curve_pairs_sampled.wgsl", "common/walk_slabs_uniform.wgsl"]
        }
        Tier::Native => {
            crate::sources!["common/curve_pairs_stored.wgsl", "common/walk_slabs.wgsl"]
        }
    }
}

const fn disc_walk_sources(tier: Tier) -> &'static [Source] {
    match tier {
        Tier::Core => walk_sources(tier),
        Tier::Native => crate::sources![
            "common/curve_pairs_stored.wgsl",
            "common/disc_lanes.wgsl",
            "common/walk_slab_discs.wgsl"
        ],
    }
}

const NODES: Constant = ("NODES", 8.0);
const CURVE_CONSTANTS: &[Constant] = &[NODES, ("HAS_QUADS", 1.0), ("HAS_GAIN", 0.0)];
const HIT_VISIT_CONSTANTS: &[Constant] = join![
    Constant: CURVE_CONSTANTS,
    HIT_CONSTANTS,
    &[("HAS_OVER", 1.0), ("HAS_VOLUMES", 1.0)],
];
const DISC_VISIT_CONSTANTS: &[Constant] =
    join![Constant: CURVE_CONSTANTS, &[("PERSPECTIVE", 0.0), ("HAS_OPAQUE", 1.0), WIDE]];

const PARTIALS: Binding = Binding::read_write::<[u32; 4]>("partials");
const COUNTERS: Binding = Binding::read_write::<BatchCounters>("counters");
/// What a tile is written to that is finished.
const MAP_BINDINGS: &[Binding] = &[
    Binding::texture_write("filters", Rgba16Float).array(),
    Binding::texture_write("nearests", R32Float).array(),
    Binding::texture_write("curves", Rgba32Uint).array(),
];
const TILE_BINDINGS: [&[Binding]; 2] = on_each_tier!(TIER => join![
    Binding: sums(TIER),
    &[
        VIEWS,
        MATERIALS,
        TILE_LIST,
        Binding::read::<u32>("scattered_tiles"),
        COUNTERS,
        FOOTPRINTS,
        pairs(TIER),
        CASTERS,
        SETUPS,
        IMAGES,
        OPAQUES,
    ],
    MAP_BINDINGS,
]);
const SEGMENT_BINDINGS: [&[Binding]; 2] = on_each_tier!(TIER => &[
    VIEWS,
    MATERIALS,
    DISPATCHES,
    SEGMENT_LIST,
    PARTIALS,
    COUNTERS,
    FOOTPRINTS,
    CASTERS,
    SETUPS,
    IMAGES,
    pairs(TIER),
    OPAQUES,
]);

pub const TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_curve_tiles",
    sources: join![
        Source: HIT_VISIT_SOURCES,
        sums_sources(TIER),
        walk_sources(TIER),
        TILE_SOURCES,
    ],
    bindings: TILE_BINDINGS[TIER as usize],
    constants: HIT_VISIT_CONSTANTS,
    tier: TIER,
});
pub const SEGMENTS: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_curve_segments",
    sources: join![Source: HIT_VISIT_SOURCES, walk_sources(TIER), SEGMENT_SOURCES],
    bindings: SEGMENT_BINDINGS[TIER as usize],
    constants: HIT_VISIT_CONSTANTS,
    tier: TIER,
});
pub const DISC_TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_curve_tiles",
    sources: join![
        Source: DISC_VISIT_SOURCES,
        sums_sources(TIER),
        disc_walk_sources(TIER),
        TILE_SOURCES,
    ],
    bindings: TILE_BINDINGS[TIER as usize],
    constants: DISC_VISIT_CONSTANTS,
    tier: TIER,
});
pub const DISC_SEGMENTS: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_curve_segments",
    sources: join![Source: DISC_VISIT_SOURCES, disc_walk_sources(TIER), SEGMENT_SOURCES],
    bindings: SEGMENT_BINDINGS[TIER as usize],
    constants: DISC_VISIT_CONSTANTS,
    tier: TIER,
});

pub const RESOLVE: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "resolve_curve",
    sources: join![
        Source: RESOLVE_SOURCES,
        sums_sources(TIER),
        crate::sources![
            "common/curve.wgsl",
            "common/order.wgsl",
            "common/volumes.wgsl",
            "common/light4.wgsl",
        "common/curve_list.wgsl",
            "common/curve_volumes.wgsl",
            "common/curve_partial.wgsl",
            "common/overflow_curve.wgsl",
            "resolve_curve.wgsl"
        ],
    ],
    bindings: join![
        Binding: sums(TIER),
        RESOLVE_BINDINGS,
        &[Binding::read::<[u32; 4]>("partials")],
        MAP_BINDINGS,
    ],
    constants: &[NODES, ("HAS_GAIN", 0.0), ("HAS_OVER", 0.0), ("HAS_VOLUMES", 0.0)],
    tier: TIER,
});
