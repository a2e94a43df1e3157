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

pub const TILES_CORE: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/reach.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather.wgsl",
        "common/walk_uniform.wgsl",
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
        ("HAS_QUADS", 1.0),
        ("HAS_GAIN", 0.0),
    ],
    tier: Tier::Core,
};

pub const SEGMENTS_CORE: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/sums_buffer.wgsl",
        "common/merge.wgsl",
        "common/dispatch.wgsl",
        "common/reach.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather.wgsl",
        "common/walk_uniform.wgsl",
        "accumulate_segments.wgsl"
    ],
    bindings: crate::sums_then![
        buffer,
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
        ("HAS_QUADS", 1.0),
        ("HAS_GAIN", 0.0),
    ],
    tier: Tier::Core,
};

pub const TINY_CORE: KernelDesc = KernelDesc {
    name: "accumulate_tiny",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/sums_buffer.wgsl",
        "common/merge.wgsl",
        "common/bin.wgsl",
        "common/chunk.wgsl",
        "common/hash.wgsl",
        "common/lane.wgsl",
        "common/scatter.wgsl",
        "accumulate_tiny.wgsl"
    ],
    bindings: crate::sums_then![
        buffer,
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
        ("HAS_GAIN", 0.0),
        ("WORKGROUP_SIZE", CHUNK_SIZE as f64),
    ],
    tier: Tier::Core,
};

pub const OVERFLOW_CORE: KernelDesc = KernelDesc {
    name: "accumulate_overflow",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/sums_buffer.wgsl",
        "common/merge.wgsl",
        "common/dispatch.wgsl",
        "common/hash.wgsl",
        "common/lane.wgsl",
        "common/scatter.wgsl",
        "accumulate_overflow.wgsl"
    ],
    bindings: crate::sums_then![
        buffer,
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
        ("HAS_GAIN", 0.0),
    ],
    tier: Tier::Core,
};

pub const TILES_NATIVE: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/reach.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather.wgsl",
        "common/walk_subgroup.wgsl",
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
        ("HAS_QUADS", 1.0),
        ("HAS_GAIN", 0.0),
    ],
    tier: Tier::Native,
};

pub const SEGMENTS_NATIVE: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/sums_texture.wgsl",
        "common/merge.wgsl",
        "common/dispatch.wgsl",
        "common/reach.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather.wgsl",
        "common/walk_subgroup.wgsl",
        "accumulate_segments.wgsl"
    ],
    bindings: crate::sums_then![
        texture,
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
        ("HAS_QUADS", 1.0),
        ("HAS_GAIN", 0.0),
    ],
    tier: Tier::Native,
};

pub const TINY_NATIVE: KernelDesc = KernelDesc {
    name: "accumulate_tiny",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/sums_texture.wgsl",
        "common/merge.wgsl",
        "common/bin.wgsl",
        "common/chunk.wgsl",
        "common/hash.wgsl",
        "common/lane.wgsl",
        "common/scatter.wgsl",
        "accumulate_tiny.wgsl"
    ],
    bindings: crate::sums_then![
        texture,
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
        ("HAS_GAIN", 0.0),
        ("WORKGROUP_SIZE", CHUNK_SIZE as f64),
    ],
    tier: Tier::Native,
};

pub const OVERFLOW_NATIVE: KernelDesc = KernelDesc {
    name: "accumulate_overflow",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/hit.wgsl",
        "common/texture.wgsl",
        "common/caster_hit.wgsl",
        "common/sums.wgsl",
        "common/sums_texture.wgsl",
        "common/merge.wgsl",
        "common/dispatch.wgsl",
        "common/hash.wgsl",
        "common/lane.wgsl",
        "common/scatter.wgsl",
        "accumulate_overflow.wgsl"
    ],
    bindings: crate::sums_then![
        texture,
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
        ("HAS_GAIN", 0.0),
    ],
    tier: Tier::Native,
};

pub const DISC_TILES_CORE: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/sums.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather_discs.wgsl",
        "common/walk_discs_uniform.wgsl",
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
    constants: &[("HAS_GAIN", 0.0), ("PERSPECTIVE", 0.0)],
    tier: Tier::Core,
};

pub const DISC_SEGMENTS_CORE: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/sums.wgsl",
        "common/sums_buffer.wgsl",
        "common/merge.wgsl",
        "common/dispatch.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather_discs.wgsl",
        "common/walk_discs_uniform.wgsl",
        "accumulate_segments.wgsl"
    ],
    bindings: crate::sums_then![
        buffer,
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
    constants: &[("HAS_GAIN", 0.0), ("PERSPECTIVE", 0.0)],
    tier: Tier::Core,
};

pub const DISC_TILES_NATIVE: KernelDesc = KernelDesc {
    name: "accumulate_tiles",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/sums.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather_discs.wgsl",
        "common/walk_discs.wgsl",
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
    constants: &[("HAS_GAIN", 0.0), ("PERSPECTIVE", 0.0)],
    tier: Tier::Native,
};

pub const DISC_SEGMENTS_NATIVE: KernelDesc = KernelDesc {
    name: "accumulate_segments",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/material.wgsl",
        "common/tile_rect.wgsl",
        "common/sums.wgsl",
        "common/sums_texture.wgsl",
        "common/merge.wgsl",
        "common/dispatch.wgsl",
        "common/lane.wgsl",
        "common/tile.wgsl",
        "common/gather_discs.wgsl",
        "common/walk_discs.wgsl",
        "accumulate_segments.wgsl"
    ],
    bindings: crate::sums_then![
        texture,
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
    constants: &[("HAS_GAIN", 0.0), ("PERSPECTIVE", 0.0)],
    tier: Tier::Native,
};
