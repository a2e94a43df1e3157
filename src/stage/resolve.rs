//! resolve: sums to filter, nearest and opaque depth, for the tiles that several workgroups or the
//! scatter path added to.
use super::{bin::Tile, hits::VIEWS};
use crate::gpu::{Binding, KernelDesc, Tier};
use wgpu::TextureFormat::{R32Float, Rgba16Float};

pub const TILES_CORE: KernelDesc = KernelDesc {
    name: "resolve_tiles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/tile.wgsl",
        "common/rows_4.wgsl",
        "common/lane.wgsl",
        "common/sums.wgsl",
        "common/sums_buffer.wgsl",
        "common/dispatch.wgsl",
        "resolve_tiles.wgsl"
    ],
    bindings: crate::sums_then![
        buffer,
        VIEWS,
        Binding::read::<[u32; 4]>("dispatches"),
        Binding::read::<u32>("merged_tiles"),
        Binding::read::<Tile>("tiles"),
        Binding::texture_write("filters", Rgba16Float).array(),
        Binding::texture_write("nearests", R32Float).array()
    ],
    constants: &[("HAS_GAIN", 0.0)],
    tier: Tier::Core,
};

pub const OPAQUE_CORE: KernelDesc = KernelDesc {
    name: "resolve_opaque",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/tile.wgsl",
        "common/rows_4.wgsl",
        "common/lane.wgsl",
        "common/sums.wgsl",
        "common/sums_buffer.wgsl",
        "common/dispatch.wgsl",
        "resolve_opaque.wgsl"
    ],
    bindings: crate::sums_then![
        buffer,
        VIEWS,
        Binding::read::<[u32; 4]>("dispatches"),
        Binding::read::<u32>("merged_tiles"),
        Binding::read::<Tile>("tiles"),
        Binding::texture_write("opaques", R32Float).array()
    ],
    constants: &[("HAS_GAIN", 0.0)],
    tier: Tier::Core,
};

pub const TILES_NATIVE: KernelDesc = KernelDesc {
    name: "resolve_tiles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/tile.wgsl",
        "common/rows_4.wgsl",
        "common/lane.wgsl",
        "common/sums.wgsl",
        "common/sums_texture.wgsl",
        "common/dispatch.wgsl",
        "resolve_tiles.wgsl"
    ],
    bindings: crate::sums_then![
        texture,
        VIEWS,
        Binding::read::<[u32; 4]>("dispatches"),
        Binding::read::<u32>("merged_tiles"),
        Binding::read::<Tile>("tiles"),
        Binding::texture_write("filters", Rgba16Float).array(),
        Binding::texture_write("nearests", R32Float).array()
    ],
    constants: &[("HAS_GAIN", 0.0)],
    tier: Tier::Native,
};

pub const OPAQUE_NATIVE: KernelDesc = KernelDesc {
    name: "resolve_opaque",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/tile.wgsl",
        "common/rows_4.wgsl",
        "common/lane.wgsl",
        "common/sums.wgsl",
        "common/sums_texture.wgsl",
        "common/dispatch.wgsl",
        "resolve_opaque.wgsl"
    ],
    bindings: crate::sums_then![
        texture,
        VIEWS,
        Binding::read::<[u32; 4]>("dispatches"),
        Binding::read::<u32>("merged_tiles"),
        Binding::read::<Tile>("tiles"),
        Binding::texture_write("opaques", R32Float).array()
    ],
    constants: &[("HAS_GAIN", 0.0)],
    tier: Tier::Native,
};
