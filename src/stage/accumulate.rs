//! accumulate: front to back through each tile's pairs, in registers.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths. Out: `filters` and `nearests` of
//! tiles that one workgroup finishes; sums of the others, of tiny particles and of overflow.
use super::{
    bin::{BatchCounters, Segment, Tile},
    hits::{CASTERS, IMAGES, MATERIALS, OPAQUES, SETUPS, VIEWS},
    project::{CHUNK_SIZE, Chunk, ProjectParams},
};
use crate::gpu::{Binding, KernelDesc, Tier};
use wgpu::{
    TextureFormat::{R32Float, Rg32Uint, Rgba16Float, Rgba32Uint},
    TextureSampleType::Uint,
};

/// Workgroups of `tiny`: 8,192 invocations in flight, each adding at most 7 * 65,536 to a texel,
/// stay below 2^32.
pub const TINY_GROUPS: u32 = 32;

macro_rules! tiles {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "accumulate_tiles",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/order.wgsl",
                "common/volumes.wgsl",
                "common/owners.wgsl",
                "common/owner.wgsl",
                "common/sums.wgsl",
                "common/crossing.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather.wgsl",
                $walk,
                "accumulate_tiles.wgsl"
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
                OPAQUES,
                Binding::texture_write("filters", Rgba16Float).array(),
                Binding::texture_write("nearests", R32Float).array(),
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_QUADS", 1.0),
                ("HAS_GAIN", 0.0),
                ("HAS_OVER", 0.0),
                ("HAS_VOLUMES", 0.0),
                ("HAS_OWNERS", 0.0),
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
            name: "accumulate_segments",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/order.wgsl",
                "common/volumes.wgsl",
                "common/owners.wgsl",
                "common/owner.wgsl",
                "common/sums.wgsl",
                "common/crossing.wgsl",
                $sums_file,
                "common/merge.wgsl",
                "common/dispatch.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather.wgsl",
                $walk,
                "accumulate_segments.wgsl"
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
                IMAGES,
                OPAQUES
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_QUADS", 1.0),
                ("HAS_GAIN", 0.0),
                ("HAS_OVER", 0.0),
                ("HAS_VOLUMES", 0.0),
                ("HAS_OWNERS", 0.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const SEGMENTS: [KernelDesc; 2] = [
    segments!(Core, buffer, "common/sums_buffer.wgsl", "common/walk_uniform.wgsl"),
    segments!(Native, texture, "common/sums_texture.wgsl", "common/walk_subgroup.wgsl"),
];

macro_rules! ordered {
    ($tier:ident, $sums:ident, $sums_file:literal, $walk:literal) => {
        KernelDesc {
            name: "accumulate_ordered",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/order.wgsl",
                "common/volumes.wgsl",
                "common/owners.wgsl",
                "common/owner.wgsl",
                "common/sums.wgsl",
                "common/crossing.wgsl",
                $sums_file,
                "common/merge.wgsl",
                "common/partial.wgsl",
                "common/dispatch.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather.wgsl",
                $walk,
                "accumulate_ordered.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                VIEWS,
                MATERIALS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<Segment>("segments"),
                Binding::read::<Tile>("tiles"),
                Binding::read_write::<[u32; 4]>("partials"),
                Binding::texture_read("pairs", Rg32Uint),
                Binding::texture_read("footprints", Rgba32Uint),
                CASTERS,
                SETUPS,
                IMAGES,
                OPAQUES
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_QUADS", 1.0),
                ("HAS_GAIN", 0.0),
                ("HAS_OVER", 1.0),
                ("HAS_VOLUMES", 1.0),
                ("HAS_OWNERS", 1.0),
            ],
            tier: Tier::$tier,
        }
    };
}
/// In place of [`SEGMENTS`] where segments are composed one by one.
pub const ORDERED: [KernelDesc; 2] = [
    ordered!(Core, buffer, "common/sums_buffer.wgsl", "common/walk_uniform.wgsl"),
    ordered!(Native, texture, "common/sums_texture.wgsl", "common/walk_subgroup.wgsl"),
];

macro_rules! tiny {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "accumulate_tiny",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/order.wgsl",
                "common/volumes.wgsl",
                "common/sums.wgsl",
                "common/crossing.wgsl",
                $sums_file,
                "common/merge.wgsl",
                "common/bin.wgsl",
                "common/chunk.wgsl",
                "common/hash.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/scatter.wgsl",
                "accumulate_tiny.wgsl"
            ],
            bindings: crate::sums_then![
                $sums,
                Binding::uniform::<ProjectParams>("params"),
                VIEWS,
                MATERIALS,
                Binding::read::<Chunk>("chunks"),
                Binding::read_write::<u32>("scattered_tiles"),
                Binding::read_write::<BatchCounters>("counters"),
                Binding::texture("rects", Uint),
                Binding::texture("footprints", Uint),
                CASTERS,
                SETUPS,
                IMAGES,
                OPAQUES
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_GAIN", 0.0),
                ("HAS_OVER", 0.0),
                ("HAS_VOLUMES", 0.0),
                ("WORKGROUP_SIZE", CHUNK_SIZE as f64),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const TINY: [KernelDesc; 2] = [
    tiny!(Core, buffer, "common/sums_buffer.wgsl"),
    tiny!(Native, texture, "common/sums_texture.wgsl"),
];

macro_rules! overflow {
    ($tier:ident, $sums:ident, $sums_file:literal) => {
        KernelDesc {
            name: "accumulate_overflow",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/rolled.wgsl",
                "common/order.wgsl",
                "common/volumes.wgsl",
                "common/sums.wgsl",
                "common/crossing.wgsl",
                $sums_file,
                "common/merge.wgsl",
                "common/dispatch.wgsl",
                "common/hash.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/scatter.wgsl",
                "common/overflow.wgsl",
                "accumulate_overflow.wgsl"
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
                IMAGES,
                OPAQUES
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("ROLLED", 0.0),
                ("HAS_GAIN", 0.0),
                ("HAS_OVER", 0.0),
                ("HAS_VOLUMES", 0.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const OVERFLOW: [KernelDesc; 2] = [
    overflow!(Core, buffer, "common/sums_buffer.wgsl"),
    overflow!(Native, texture, "common/sums_texture.wgsl"),
];

macro_rules! disc_tiles {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "accumulate_tiles",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/sums.wgsl",
                "common/owners.wgsl",
                "common/owner.wgsl",
                "common/rows_8.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather_discs.wgsl",
                $walk,
                "accumulate_tiles.wgsl"
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
                OPAQUES,
                Binding::texture_write("filters", Rgba16Float).array(),
                Binding::texture_write("nearests", R32Float).array(),
            ],
            constants: &[
                ("HAS_GAIN", 0.0),
                ("HAS_OWNERS", 0.0),
                ("PERSPECTIVE", 0.0),
                ("HAS_OPAQUE", 1.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const DISC_TILES: [KernelDesc; 2] = [
    disc_tiles!(Core, "common/walk_discs_uniform.wgsl"),
    disc_tiles!(Native, "common/walk_discs.wgsl"),
];

macro_rules! disc_segments {
    ($tier:ident, $sums:ident, $sums_file:literal, $walk:literal) => {
        KernelDesc {
            name: "accumulate_segments",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/sums.wgsl",
                "common/owner.wgsl",
                $sums_file,
                "common/merge.wgsl",
                "common/dispatch.wgsl",
                "common/rows_8.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/gather_discs.wgsl",
                $walk,
                "accumulate_segments.wgsl"
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
                IMAGES,
                OPAQUES
            ],
            constants: &[("HAS_GAIN", 0.0), ("PERSPECTIVE", 0.0), ("HAS_OPAQUE", 1.0)],
            tier: Tier::$tier,
        }
    };
}
pub const DISC_SEGMENTS: [KernelDesc; 2] = [
    disc_segments!(Core, buffer, "common/sums_buffer.wgsl", "common/walk_discs_uniform.wgsl"),
    disc_segments!(Native, texture, "common/sums_texture.wgsl", "common/walk_discs.wgsl"),
];
