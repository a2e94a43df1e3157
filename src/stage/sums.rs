//! What the kernels share that add to the sums of a batch's texels, or resolve them: buffers on the
//! core tier, textures that take atomics on the native one.
use super::{
    hits::{CASTERS, IMAGES, MATERIALS, SETUPS, VIEWS},
    walk::{DISPATCHES, TILES},
};
use crate::gpu::{Access, Binding, BindingKind, Source, Tier};
use wgpu::{TextureFormat::R32Uint, TextureSampleType::Uint, TextureViewDimension};

const fn atomic_texture(name: &'static str) -> Binding {
    Binding {
        name,
        kind: BindingKind::StorageTexture {
            access: Access::Atomic,
            format: R32Uint,
            dimension: TextureViewDimension::D2,
        },
    }
}

const BUFFERS: &[Binding] = &[
    Binding::read_write::<u32>("sum_red"),
    Binding::read_write::<u32>("sum_green"),
    Binding::read_write::<u32>("sum_blue"),
    Binding::read_write::<u32>("nearness"),
];
const TEXTURES: &[Binding] = &[
    atomic_texture("sum_red"),
    atomic_texture("sum_green"),
    atomic_texture("sum_blue"),
    atomic_texture("nearness"),
];

/// Before all other bindings.
pub(super) const fn sums(tier: Tier) -> &'static [Binding] {
    match tier {
        Tier::Core => BUFFERS,
        Tier::Native => TEXTURES,
    }
}

pub(super) const fn sums_sources(tier: Tier) -> &'static [Source] {
    match tier {
        Tier::Core => crate::sources!["common/sums.wgsl", "common/sums_buffer.wgsl"],
        Tier::Native => crate::sources!["common/sums.wgsl", "common/sums_texture.wgsl"],
    }
}

/// Tiles that have something in the sums.
pub(super) const SCATTERED_TILES: Binding = Binding::read_write::<u32>("scattered_tiles");
/// Sampled, because core WebGPU has 4 storage textures a stage.
pub(super) const RECTS: Binding = Binding::texture("rects", Uint);
pub(super) const SAMPLED_FOOTPRINTS: Binding = Binding::texture("footprints", Uint);

/// What did not fit the pair budget, after the sums.
pub(super) const OVERFLOW_BINDINGS: &[Binding] = &[
    VIEWS,
    MATERIALS,
    DISPATCHES,
    Binding::read::<u32>("overflow"),
    SCATTERED_TILES,
    RECTS,
    SAMPLED_FOOTPRINTS,
    CASTERS,
    SETUPS,
    IMAGES,
];

pub(super) const OVERFLOW_SOURCES: &[Source] = crate::sources![
    "common/dispatch.wgsl",
    "common/rows_4.wgsl",
    "common/lane.wgsl",
    "common/overflow.wgsl"
];

/// Of the tiles that have something in the sums, after these.
pub(super) const RESOLVE_BINDINGS: &[Binding] =
    &[VIEWS, DISPATCHES, Binding::read::<u32>("merged_tiles"), TILES];
pub(super) const RESOLVE_SOURCES: &[Source] = crate::sources![
    "common/record.wgsl",
    "common/view.wgsl",
    "common/tile.wgsl",
    "common/rows_4.wgsl",
    "common/lane.wgsl",
    "common/dispatch.wgsl"
];
