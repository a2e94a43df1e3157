//! colored: coloured dithering. Each channel of a dithered caster has a threshold of its own and an
//! opaque depth of its own, so that three depths hold coloured layers in any order (McGuire and
//! Enderton 2011). Takes the place of `occlude`, and of `filter` where shadows are softened.
//!
//! In: as of `occlude`. Out: `colored`, the opaque depths by channel; `opaques`, the last of the
//! three, behind which no light is left. Softened: maps without `colored`.
use super::{
    bin::{Segment, Tile},
    filter::FilterParams,
    hits::{CASTERS, IMAGES, MATERIALS, OPAQUES, SETUPS, SMALL_DEPTHS, VIEWS},
};
use crate::gpu::{Binding, FLOAT, KernelDesc, Tier};
use wgpu::{
    TextureFormat::{R32Float, Rg32Uint, Rgba16Float, Rgba32Float, Rgba32Uint},
    TextureSampleType::Uint,
};

macro_rules! tiles {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "colored_tiles",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/sums.wgsl",
                "common/hash.wgsl",
                "common/dither.wgsl",
                "common/solid.wgsl",
                "common/blocks.wgsl",
                "common/blocks_colored.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather_colored.wgsl",
                $walk,
                "common/small.wgsl",
                "colored_tiles.wgsl"
            ],
            bindings: &[
                VIEWS,
                MATERIALS,
                Binding::read::<Tile>("tiles"),
                Binding::texture_read("pairs", Rg32Uint),
                Binding::texture_read("footprints", Rgba32Uint),
                CASTERS,
                SETUPS,
                IMAGES,
                Binding::texture_write("opaques", R32Float).array(),
                SMALL_DEPTHS,
                Binding::texture_write("colored", Rgba32Float).array(),
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_DITHER", 1.0),
                ("HAS_QUADS", 1.0),
                ("HAS_GAIN", 0.0),
                ("HAS_SMALL", 0.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const TILES: [KernelDesc; 2] =
    [tiles!(Core, "common/walk_uniform.wgsl"), tiles!(Native, "common/walk_subgroup.wgsl")];

macro_rules! segments {
    ($tier:ident, $sums:ident, $sums_file:literal, $walk:literal) => {
        KernelDesc {
            name: "colored_segments",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/sums.wgsl",
                $sums_file,
                "common/hash.wgsl",
                "common/dither.wgsl",
                "common/solid.wgsl",
                "common/blocks.wgsl",
                "common/blocks_colored.wgsl",
                "common/dispatch.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather_colored.wgsl",
                $walk,
                "colored_segments.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                MATERIALS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<Segment>("segments"),
                Binding::texture_read("pairs", Rg32Uint),
                Binding::texture_read("footprints", Rgba32Uint),
                CASTERS,
                SETUPS,
                IMAGES
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_DITHER", 1.0),
                ("HAS_QUADS", 1.0),
                ("HAS_GAIN", 0.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const SEGMENTS: [KernelDesc; 2] = [
    segments!(Core, buffer, "common/sums_buffer.wgsl", "common/walk_uniform.wgsl"),
    segments!(Native, texture, "common/sums_texture.wgsl", "common/walk_subgroup.wgsl"),
];

macro_rules! overflow {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "colored_overflow",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/sums.wgsl",
                $sums_file,
                "common/hash.wgsl",
                "common/dither.wgsl",
                "common/solid.wgsl",
                "common/blocks.wgsl",
                "common/blocks_colored.wgsl",
                "common/dispatch.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/overflow.wgsl",
                "colored_overflow.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                MATERIALS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<u32>("overflow"),
                Binding::read_write::<u32>("scattered_tiles"),
                Binding::texture("rects", Uint),
                Binding::texture("footprints", Uint),
                CASTERS,
                SETUPS,
                IMAGES
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_DITHER", 1.0),
                ("HAS_GAIN", 0.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const OVERFLOW: [KernelDesc; 2] = [
    overflow!(Core, buffer, "common/sums_buffer.wgsl"),
    overflow!(Native, texture, "common/sums_texture.wgsl"),
];

macro_rules! resolve {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "colored_resolve",
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
                "colored_resolve.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<u32>("merged_tiles"),
                Binding::read::<Tile>("tiles"),
                Binding::texture_write("opaques", R32Float).array(),
                SMALL_DEPTHS,
                Binding::texture_write("colored", Rgba32Float).array()
            ],
            constants: &[("HAS_GAIN", 0.0), ("HAS_SMALL", 0.0)],
            tier: Tier::$tier,
        }
    };
}
pub const RESOLVE: [KernelDesc; 2] = [
    resolve!(Core, buffer, "common/sums_buffer.wgsl"),
    resolve!(Native, texture, "common/sums_texture.wgsl"),
];

const PARAMS: Binding = Binding::uniform::<FilterParams>("params");

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
    bindings: &[
        PARAMS,
        VIEWS,
        Binding::texture("rows", FLOAT).array(),
        Binding::texture("filters", FLOAT).array(),
        Binding::texture("nearests", FLOAT).array(),
        OPAQUES,
        Binding::texture_write("soft_filters", Rgba16Float).array(),
        Binding::texture_write("soft_nearests", R32Float).array(),
        Binding::texture_write("soft_opaques", R32Float).array(),
    ],
    constants: &[],
    tier: Tier::Core,
};
