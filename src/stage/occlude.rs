//! occlude: opaque, cutout and dithered casters to the opaque depth; a minimum instead of a clip.
//!
//! In: tiles or segments of `pairs`, `footprints`. Out: `opaques` of tiles that one workgroup
//! finishes; nearness sums of the others.
use super::{
    hits::{CASTER_SOURCES, HIT_CONSTANTS, HIT_SOURCES, SMALL_DEPTHS, VIEWS},
    project::{CHUNK_SIZE, Chunk, ProjectParams},
    sums::{OVERFLOW_BINDINGS, OVERFLOW_SOURCES, sums, sums_sources},
    walk::{
        LANE_SOURCES, SEGMENT_BINDINGS, TALL_LANE_SOURCES, TILE_BINDINGS, triangle_walk_sources,
        walk_sources,
    },
};
use crate::gpu::{Binding, Constant, KernelDesc, Source, Tier, join, on_each_tier};
use wgpu::TextureFormat::{R32Float, Rgba32Uint};

/// Opaque triangles of a few texels go straight to `small_depths`, one element per texel of the
/// batch: views follow each other, row by row.
pub const SMALL: KernelDesc = KernelDesc {
    name: "occlude_small",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/chunk.wgsl",
        "common/triangle_edges.wgsl",
        "occlude_small.wgsl"
    ],
    bindings: &[
        Binding::uniform::<ProjectParams>("params"),
        VIEWS,
        Binding::read::<Chunk>("chunks"),
        Binding::texture_read("triangles", Rgba32Uint),
        Binding::read_write::<u32>("small_depths"),
    ],
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    tier: Tier::Core,
};

/// A hit that blocks light.
pub(super) const BLOCKS_SOURCES: &[Source] = join![
    Source: HIT_SOURCES,
    crate::sources![
        "common/hash.wgsl",
        "common/dither.wgsl",
        "common/solid.wgsl",
        "common/blocks.wgsl"
    ],
];
pub(super) const BLOCKS_CONSTANTS: &[Constant] =
    join![Constant: HIT_CONSTANTS, &[("HAS_DITHER", 1.0)]];
/// What a tile is written to that one workgroup finishes, and what was found before.
pub(super) const DEPTH_BINDINGS: &[Binding] =
    &[Binding::texture_write("opaques", R32Float).array(), SMALL_DEPTHS];

pub const TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "occlude_tiles",
    sources: join![
        Source: BLOCKS_SOURCES,
        LANE_SOURCES,
        walk_sources(TIER),
        crate::sources!["common/gather_depth.wgsl", "common/small.wgsl", "occlude_tiles.wgsl"],
    ],
    bindings: join![Binding: TILE_BINDINGS, DEPTH_BINDINGS],
    constants: join![Constant: BLOCKS_CONSTANTS, &[("HAS_QUADS", 1.0), ("HAS_SMALL", 0.0)]],
    tier: TIER,
});

/// Of opaque triangles only.
pub const TRIANGLE_TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "occlude_tiles",
    sources: join![
        Source: CASTER_SOURCES,
        TALL_LANE_SOURCES,
        triangle_walk_sources(TIER),
        crate::sources!["common/gather_triangles.wgsl", "common/small.wgsl", "occlude_tiles.wgsl"],
    ],
    bindings: join![Binding: TILE_BINDINGS, DEPTH_BINDINGS],
    constants: &[("HAS_SMALL", 0.0)],
    tier: TIER,
});

pub const SEGMENTS: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "occlude_segments",
    sources: join![
        Source: BLOCKS_SOURCES,
        sums_sources(TIER),
        LANE_SOURCES,
        walk_sources(TIER),
        crate::sources![
            "common/dispatch.wgsl",
            "common/gather_depth.wgsl",
            "occlude_segments.wgsl"
        ],
    ],
    bindings: join![Binding: sums(TIER), SEGMENT_BINDINGS],
    constants: join![Constant: BLOCKS_CONSTANTS, &[("HAS_QUADS", 1.0), ("HAS_GAIN", 0.0)]],
    tier: TIER,
});

pub const OVERFLOW: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "occlude_overflow",
    sources: join![
        Source: BLOCKS_SOURCES,
        sums_sources(TIER),
        OVERFLOW_SOURCES,
        crate::sources!["occlude_overflow.wgsl"],
    ],
    bindings: join![Binding: sums(TIER), OVERFLOW_BINDINGS],
    constants: join![Constant: BLOCKS_CONSTANTS, &[("HAS_GAIN", 0.0)]],
    tier: TIER,
});
