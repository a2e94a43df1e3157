//! resolve: sums to filter, nearest and opaque depth, for the tiles that several workgroups or the
//! scatter path added to.
use super::{
    occlude::DEPTH_BINDINGS,
    sums::{RESOLVE_BINDINGS, RESOLVE_SOURCES, sums, sums_sources},
};
use crate::gpu::{Binding, KernelDesc, Source, join, on_each_tier};
use wgpu::TextureFormat::{R32Float, Rgba16Float};

/// What a tile is written to that is finished.
pub(super) const MAP_BINDINGS: &[Binding] = &[
    Binding::texture_write("filters", Rgba16Float).array(),
    Binding::texture_write("nearests", R32Float).array(),
];
/// The same where it is fetched before.
pub(super) const FETCHED_MAP_BINDINGS: &[Binding] = &[
    Binding::texture_read_write("filters", Rgba16Float).array(),
    Binding::texture_read_write("nearests", R32Float).array(),
];

pub const TILES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "resolve_tiles",
    sources: join![
        Source: RESOLVE_SOURCES,
        sums_sources(TIER),
        crate::sources!["resolve_tiles.wgsl"],
    ],
    bindings: join![Binding: sums(TIER), RESOLVE_BINDINGS, MAP_BINDINGS],
    constants: &[("HAS_GAIN", 0.0)],
    tier: TIER,
});

/// In place of [`TILES`] where segments are composed one by one.
pub const ORDERED: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "resolve_ordered",
    sources: join![
        Source: RESOLVE_SOURCES,
        sums_sources(TIER),
        crate::sources![
            "common/volumes.wgsl",
            "common/owners.wgsl",
            "common/owner.wgsl",
            "common/partial.wgsl",
            "resolve_ordered.wgsl"
        ],
    ],
    bindings: join![
        Binding: sums(TIER),
        RESOLVE_BINDINGS,
        &[Binding::read::<[u32; 4]>("partials")],
        MAP_BINDINGS,
    ],
    constants: &[("HAS_GAIN", 0.0), ("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
    tier: TIER,
});

pub const OPAQUE: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "resolve_opaque",
    sources: join![
        Source: RESOLVE_SOURCES,
        sums_sources(TIER),
        crate::sources!["common/small.wgsl", "resolve_opaque.wgsl"],
    ],
    bindings: join![Binding: sums(TIER), RESOLVE_BINDINGS, DEPTH_BINDINGS],
    constants: &[("HAS_GAIN", 0.0), ("HAS_SMALL", 0.0)],
    tier: TIER,
});
