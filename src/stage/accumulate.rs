//! accumulate: front to back through each tile's pairs, in registers.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths. Out: `filters` and `nearests` of
//! tiles that one workgroup finishes; sums of the others, of tiny particles and of overflow.
use super::{
    bin::BatchCounters,
    hits::{
        CASTER_SOURCES, CASTERS, HIT_CONSTANTS, HIT_SOURCES, IMAGES, MATERIALS, OPAQUES, SETUPS,
        VIEWS, WIDE,
    },
    project::{CHUNK_SIZE, Chunk, ProjectParams},
    resolve::{FETCHED_MAP_BINDINGS, MAP_BINDINGS},
    sums::{
        OVERFLOW_BINDINGS, OVERFLOW_SOURCES, RECTS, SAMPLED_FOOTPRINTS, SCATTERED_TILES, sums,
        sums_sources,
    },
    walk::{
        self, DISC_QUEUE_SOURCES, DISPATCHES, FOOTPRINTS, LANE_SOURCES, PAIRS, SEGMENT_BINDINGS,
        TALL_LANE_SOURCES, TILE_BINDINGS, disc_walk_sources, walk_sources,
    },
};
use crate::gpu::{Binding, Constant, KernelDesc, Source, Tier, join, on_each_tier};

/// Workgroups of `tiny`: 8,192 invocations in flight, each adding at most 7 * 65,536 to a texel,
/// stay below 2^32.
pub const TINY_GROUPS: u32 = 32;

/// A hit that filters light.
const CROSSING_SOURCES: &[Source] = join![
    Source: HIT_SOURCES,
    crate::sources!["common/order.wgsl", "common/volumes.wgsl", "common/crossing.wgsl"],
];
const CROSSING_CONSTANTS: &[Constant] = join![
    Constant: HIT_CONSTANTS,
    &[("HAS_GAIN", 0.0), ("HAS_OVER", 0.0), ("HAS_VOLUMES", 0.0)],
];
/// Light of four texels.
const GATHER_SOURCES: &[Source] = join![
    Source: CROSSING_SOURCES,
    LANE_SOURCES,
    crate::sources![
        "common/owners.wgsl",
        "common/owner.wgsl",
        "common/light4.wgsl",
        "common/hit_order.wgsl",
        "common/key_depths.wgsl",
        "common/gather.wgsl"
    ],
];
const GATHER_CONSTANTS: &[Constant] =
    join![Constant: CROSSING_CONSTANTS, &[("HAS_QUADS", 1.0), ("HAS_OWNERS", 0.0)]];
/// Light of eight texels, of soft discs of the `filter` transfer only.
const DISC_SOURCES: &[Source] = join![
    Source: CASTER_SOURCES,
    TALL_LANE_SOURCES,
    crate::sources![
        "common/owner.wgsl",
        "common/wide.wgsl",
        "common/disc.wgsl",
        "common/gather_discs.wgsl"
    ],
];
const DISC_CONSTANTS: &[Constant] =
    &[("HAS_GAIN", 0.0), ("PERSPECTIVE", 0.0), ("HAS_OPAQUE", 1.0), WIDE];

pub const TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_tiles",
    sources: join![
        Source: GATHER_SOURCES,
        walk_sources(TIER),
        crate::sources!["common/sums.wgsl", "common/maps.wgsl", "accumulate_tiles.wgsl"],
    ],
    bindings: join![Binding: TILE_BINDINGS, &[OPAQUES], MAP_BINDINGS],
    constants: GATHER_CONSTANTS,
    tier: TIER,
});

pub const SEGMENTS: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_segments",
    sources: join![
        Source: GATHER_SOURCES,
        sums_sources(TIER),
        walk_sources(TIER),
        crate::sources!["common/merge.wgsl", "common/dispatch.wgsl", "accumulate_segments.wgsl"],
    ],
    bindings: join![Binding: sums(TIER), SEGMENT_BINDINGS, &[OPAQUES]],
    constants: GATHER_CONSTANTS,
    tier: TIER,
});

/// In place of [`SEGMENTS`] where segments are composed one by one.
pub const ORDERED: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_ordered",
    sources: join![
        Source: GATHER_SOURCES,
        sums_sources(TIER),
        walk_sources(TIER),
        crate::sources![
            "common/merge.wgsl",
            "common/partial.wgsl",
            "common/dispatch.wgsl",
            "accumulate_ordered.wgsl"
        ],
    ],
    bindings: join![
        Binding: sums(TIER),
        &[
            VIEWS,
            MATERIALS,
            DISPATCHES,
            walk::SEGMENTS,
            walk::TILES,
            Binding::read_write::<[u32; 4]>("partials"),
            PAIRS,
            FOOTPRINTS,
            CASTERS,
            SETUPS,
            IMAGES,
            OPAQUES,
        ],
    ],
    constants: join![
        Constant: HIT_CONSTANTS,
        &[
            ("HAS_QUADS", 1.0),
            ("HAS_GAIN", 0.0),
            ("HAS_OVER", 1.0),
            ("HAS_VOLUMES", 1.0),
            ("HAS_OWNERS", 1.0),
        ],
    ],
    tier: TIER,
});

pub const TINY: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_tiny",
    sources: join![
        Source: CROSSING_SOURCES,
        sums_sources(TIER),
        crate::sources![
            "common/merge.wgsl",
            "common/bin.wgsl",
            "common/chunk.wgsl",
            "common/hash.wgsl",
            "common/rows_4.wgsl",
            "common/lane.wgsl",
            "common/scatter.wgsl",
            "accumulate_tiny.wgsl"
        ],
    ],
    bindings: join![
        Binding: sums(TIER),
        &[
            Binding::uniform::<ProjectParams>("params"),
            VIEWS,
            MATERIALS,
            Binding::read::<Chunk>("chunks"),
            SCATTERED_TILES,
            Binding::read_write::<BatchCounters>("counters"),
            RECTS,
            SAMPLED_FOOTPRINTS,
            CASTERS,
            SETUPS,
            IMAGES,
            OPAQUES,
        ],
    ],
    constants: join![Constant: CROSSING_CONSTANTS, &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)]],
    tier: TIER,
});

pub const OVERFLOW: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_overflow",
    sources: join![
        Source: CROSSING_SOURCES,
        sums_sources(TIER),
        OVERFLOW_SOURCES,
        crate::sources![
            "common/merge.wgsl",
            "common/hash.wgsl",
            "common/scatter.wgsl",
            "accumulate_overflow.wgsl"
        ],
    ],
    bindings: join![Binding: sums(TIER), OVERFLOW_BINDINGS, &[OPAQUES]],
    constants: CROSSING_CONSTANTS,
    tier: TIER,
});

pub const DISC_TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_tiles",
    sources: join![
        Source: DISC_SOURCES,
        disc_walk_sources(TIER),
        crate::sources!["common/maps.wgsl"],
        DISC_TILE_SOURCES,
    ],
    bindings: join![Binding: TILE_BINDINGS, &[OPAQUES], MAP_BINDINGS],
    constants: join![Constant: DISC_CONSTANTS, &[("HAS_OWNERS", 0.0)]],
    tier: TIER,
});
/// In place of [`DISC_TILES`] where discs wait in a queue.
pub const DISC_QUEUE_TILES: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    sources: join![
        Source: DISC_SOURCES,
        DISC_QUEUE_SOURCES,
        crate::sources!["common/maps_fetched.wgsl"],
        DISC_TILE_SOURCES,
    ],
    bindings: join![Binding: TILE_BINDINGS, &[OPAQUES], FETCHED_MAP_BINDINGS],
    constants: join![Constant: DISC_CONSTANTS, &[("HAS_OWNERS", 0.0), ("DENSE", 1.0)]],
    tier: Tier::Native,
};
const DISC_TILE_SOURCES: &[Source] =
    crate::sources!["common/sums.wgsl", "common/owners.wgsl", "accumulate_tiles.wgsl"];

pub const DISC_SEGMENTS: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "accumulate_segments",
    sources: join![
        Source: DISC_SOURCES,
        sums_sources(TIER),
        disc_walk_sources(TIER),
        DISC_SEGMENT_SOURCES,
    ],
    bindings: join![Binding: sums(TIER), SEGMENT_BINDINGS, &[OPAQUES]],
    constants: DISC_CONSTANTS,
    tier: TIER,
});
/// In place of [`DISC_SEGMENTS`] where discs wait in a queue.
pub const DISC_QUEUE_SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    sources: join![
        Source: DISC_SOURCES,
        sums_sources(Tier::Native),
        DISC_QUEUE_SOURCES,
        DISC_SEGMENT_SOURCES,
    ],
    bindings: join![Binding: sums(Tier::Native), SEGMENT_BINDINGS, &[OPAQUES]],
    constants: join![Constant: DISC_CONSTANTS, &[("DENSE", 1.0)]],
    tier: Tier::Native,
};
const DISC_SEGMENT_SOURCES: &[Source] =
    crate::sources!["common/merge.wgsl", "common/dispatch.wgsl", "accumulate_segments.wgsl"];
