//! occlude: opaque, cutout and dithered casters to the opaque depth; a minimum instead of a clip.
//!
//! In: tiles or segments of `pairs`, `footprints`. Out: `opaques` of tiles that one workgroup
//! finishes; nearness sums of the others.
use super::{
    bin::{Segment, Tile},
    hits::{CASTERS, IMAGES, MATERIALS, SETUPS, SMALL_DEPTHS, VIEWS},
    project::{CHUNK_SIZE, Chunk, ProjectParams},
};
use crate::gpu::{Binding, KernelDesc, Tier};
use wgpu::{
    TextureFormat::{R32Float, Rg32Uint, Rgba32Uint},
    TextureSampleType::Uint,
};

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

macro_rules! tiles {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "occlude_tiles",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/hash.wgsl",
                "common/dither.wgsl",
                "common/solid.wgsl",
                "common/blocks.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather_depth.wgsl",
                $walk,
                "common/small.wgsl",
                "occlude_tiles.wgsl"
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
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_DITHER", 1.0),
                ("HAS_QUADS", 1.0),
                ("HAS_SMALL", 0.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const TILES: [KernelDesc; 2] =
    [tiles!(Core, "common/walk_uniform.wgsl"), tiles!(Native, "common/walk_subgroup.wgsl")];

macro_rules! triangle_tiles {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "occlude_tiles",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/rows_8.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather_triangles.wgsl",
                $walk,
                "common/small.wgsl",
                "occlude_tiles.wgsl"
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
            ],
            constants: &[("HAS_SMALL", 0.0)],
            tier: Tier::$tier,
        }
    };
}
/// Of opaque triangles only.
pub const TRIANGLE_TILES: [KernelDesc; 2] = [
    triangle_tiles!(Core, "common/walk_triangles_uniform.wgsl"),
    triangle_tiles!(Native, "common/walk_triangles.wgsl"),
];

macro_rules! segments {
    ($tier:ident, $sums:ident, $sums_file:literal, $walk:literal) => {
        KernelDesc {
            name: "occlude_segments",
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
                "common/dispatch.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather_depth.wgsl",
                $walk,
                "occlude_segments.wgsl"
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
            name: "occlude_overflow",
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
                "common/dispatch.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/overflow.wgsl",
                "occlude_overflow.wgsl"
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
