//! colored: coloured dithering. Each channel of a dithered caster has a threshold of its own and an
//! opaque depth of its own, so that three depths hold coloured layers in any order (McGuire and
//! Enderton 2011). Takes the place of `occlude`, and of `filter` where shadows are softened.
//!
//! In: as of `occlude`. Out: `colored`, the opaque depths by channel; `opaques`, the last of the
//! three, behind which no light is left. Softened: maps without `colored`.
use super::{
    filter::{COLUMNS_BINDINGS, PARAMS},
    hits::VIEWS,
    occlude::{BLOCKS_CONSTANTS, BLOCKS_SOURCES, DEPTH_BINDINGS},
    sums::{
        OVERFLOW_BINDINGS, OVERFLOW_SOURCES, RESOLVE_BINDINGS, RESOLVE_SOURCES, sums, sums_sources,
    },
    walk::{LANE_SOURCES, SEGMENT_BINDINGS, TILE_BINDINGS, walk_sources},
};
use crate::gpu::{Binding, Constant, FLOAT, KernelDesc, Source, Tier, join, on_each_tier};
use wgpu::TextureFormat::Rgba32Float;

/// A hit that blocks some channels of light, and depths by channel in the sums.
const COLORED_SOURCES: &[Source] =
    join![Source: BLOCKS_SOURCES, crate::sources!["common/blocks_colored.wgsl"]];
const COLORED_CONSTANTS: &[Constant] = join![Constant: BLOCKS_CONSTANTS, &[("HAS_GAIN", 0.0)]];
const COLORED: Binding = Binding::texture_write("colored", Rgba32Float).array();

pub const TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "colored_tiles",
    sources: join![
        Source: COLORED_SOURCES,
        LANE_SOURCES,
        walk_sources(TIER),
        crate::sources![
            "common/sums.wgsl",
            "common/gather_colored.wgsl",
            "common/small.wgsl",
            "colored_tiles.wgsl"
        ],
    ],
    bindings: join![Binding: TILE_BINDINGS, DEPTH_BINDINGS, &[COLORED]],
    constants: join![Constant: COLORED_CONSTANTS, &[("HAS_QUADS", 1.0), ("HAS_SMALL", 0.0)]],
    tier: TIER,
});

pub const SEGMENTS: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "colored_segments",
    sources: join![
        Source: COLORED_SOURCES,
        sums_sources(TIER),
        LANE_SOURCES,
        walk_sources(TIER),
        crate::sources![
            "common/dispatch.wgsl",
            "common/gather_colored.wgsl",
            "colored_segments.wgsl"
        ],
    ],
    bindings: join![Binding: sums(TIER), SEGMENT_BINDINGS],
    constants: join![Constant: COLORED_CONSTANTS, &[("HAS_QUADS", 1.0)]],
    tier: TIER,
});

pub const OVERFLOW: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "colored_overflow",
    sources: join![
        Source: COLORED_SOURCES,
        sums_sources(TIER),
        OVERFLOW_SOURCES,
        crate::sources!["colored_overflow.wgsl"],
    ],
    bindings: join![Binding: sums(TIER), OVERFLOW_BINDINGS],
    constants: COLORED_CONSTANTS,
    tier: TIER,
});

pub const RESOLVE: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "colored_resolve",
    sources: join![
        Source: RESOLVE_SOURCES,
        sums_sources(TIER),
        crate::sources!["common/small.wgsl", "colored_resolve.wgsl"],
    ],
    bindings: join![Binding: sums(TIER), RESOLVE_BINDINGS, DEPTH_BINDINGS, &[COLORED]],
    constants: &[("HAS_GAIN", 0.0), ("HAS_SMALL", 0.0)],
    tier: TIER,
});

pub const ROWS: KernelDesc = KernelDesc {
    name: "colored_rows",
    sources: crate::sources![
        "common/view.wgsl",
        "common/window.wgsl",
        "common/window_colored.wgsl",
        "colored_rows.wgsl"
    ],
    bindings: &[
        PARAMS,
        VIEWS,
        Binding::texture("colored", FLOAT).array(),
        Binding::texture_write("rows", Rgba32Float).array(),
    ],
    constants: &[],
    tier: Tier::Core,
};

pub const COLUMNS: KernelDesc = KernelDesc {
    name: "colored_columns",
    sources: crate::sources![
        "common/view.wgsl",
        "common/window.wgsl",
        "common/window_colored.wgsl",
        "colored_columns.wgsl"
    ],
    bindings: COLUMNS_BINDINGS,
    constants: &[],
    tier: Tier::Core,
};
