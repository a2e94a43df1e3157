//! resolve: sums to filter, nearest and opaque depth, for the tiles that several workgroups or the
//! scatter path added to.
use super::{
    bin::Tile,
    hits::{SMALL_DEPTHS, VIEWS},
};
use crate::gpu::{Binding, KernelDesc, Tier};
use wgpu::TextureFormat::{R32Float, Rgba16Float};

macro_rules! tiles {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "resolve_tiles",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/tile.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/sums.wgsl",
                $sums_file,
                "common/dispatch.wgsl",
                "resolve_tiles.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<u32>("merged_tiles"),
                Binding::read::<Tile>("tiles"),
                Binding::texture_write("filters", Rgba16Float).array(),
                Binding::texture_write("nearests", R32Float).array()
            ],
            constants: &[("HAS_GAIN", 0.0)],
            tier: Tier::$tier,
        }
    };
}
pub const TILES: [KernelDesc; 2] = [
    tiles!(Core, buffer, "common/sums_buffer.wgsl"),
    tiles!(Native, texture, "common/sums_texture.wgsl"),
];

macro_rules! ordered {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "resolve_ordered",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/tile.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/volumes.wgsl",
                "common/owners.wgsl",
                "common/owner.wgsl",
                "common/sums.wgsl",
                $sums_file,
                "common/partial.wgsl",
                "common/dispatch.wgsl",
                "resolve_ordered.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<u32>("merged_tiles"),
                Binding::read::<Tile>("tiles"),
                Binding::read::<[u32; 4]>("partials"),
                Binding::texture_write("filters", Rgba16Float).array(),
                Binding::texture_write("nearests", R32Float).array()
            ],
            constants: &[("HAS_GAIN", 0.0), ("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
            tier: Tier::$tier,
        }
    };
}
/// In place of [`TILES`] where segments are composed one by one.
pub const ORDERED: [KernelDesc; 2] = [
    ordered!(Core, buffer, "common/sums_buffer.wgsl"),
    ordered!(Native, texture, "common/sums_texture.wgsl"),
];

macro_rules! opaque {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "resolve_opaque",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/tile.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/sums.wgsl",
                $sums_file,
                "common/dispatch.wgsl",
                "common/small.wgsl",
                "resolve_opaque.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<u32>("merged_tiles"),
                Binding::read::<Tile>("tiles"),
                Binding::texture_write("opaques", R32Float).array(),
                SMALL_DEPTHS
            ],
            constants: &[("HAS_GAIN", 0.0), ("HAS_SMALL", 0.0)],
            tier: Tier::$tier,
        }
    };
}
pub const OPAQUE: [KernelDesc; 2] = [
    opaque!(Core, buffer, "common/sums_buffer.wgsl"),
    opaque!(Native, texture, "common/sums_texture.wgsl"),
];
