//! shade: the lit picture. Surfaces and casters get their light through the shadow maps; casters
//! are laid over the surfaces front to back.
//!
//! In: the camera's lists, the shadow maps. Out: `pixels`. Tiles with more pairs than one segment
//! are walked a segment at a time: `seen` and `layers` leave `partials`, which `surfaces` and
//! `composite` put together in order.
use super::{
    bin::{Segment, Tile},
    hits::{CASTERS, IMAGES, MATERIALS, OPAQUES, SETUPS, VIEWS},
};
use crate::{
    gpu::{Binding, FLOAT, KernelDesc, Tier},
    light::{Light, LightKind},
    view::{GpuView, View},
};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};
use wgpu::{
    TextureFormat::{Rg32Uint, Rgba16Float, Rgba32Float, Rgba32Uint},
    TextureSampleType::Uint,
};

/// Lights of a picture: the length of the uniform array.
pub const MAX_LIGHTS: usize = 512;
/// Shadow views of a picture: the length of the uniform array.
pub const MAX_SHADOW_VIEWS: usize = 512;
/// Invocations of a workgroup of [`CASTERS_LIT`].
pub const CASTER_LANES: u32 = 64;

pub(super) const PARAMS: Binding = Binding::uniform::<PictureParams>("params");
pub(super) const LIGHTS: Binding = Binding::uniform::<[GpuLight; MAX_LIGHTS]>("lights");
pub(super) const SHADOW_VIEWS: Binding =
    Binding::uniform::<[GpuView; MAX_SHADOW_VIEWS]>("shadow_views");
const AIR: Binding = Binding::texture("air", FLOAT).array();
const TRIANGLES: Binding = Binding::texture("triangles", Uint);
pub(super) const FILTERS: Binding = Binding::texture("filters", FLOAT).array();
pub(super) const NEARESTS: Binding = Binding::texture("nearests", FLOAT).array();

macro_rules! seen {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "shade_seen",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/dispatch.wgsl",
                "common/solid.wgsl",
                "common/gather_seen.wgsl",
                $walk,
                "shade_seen.wgsl"
            ],
            bindings: &[
                VIEWS,
                MATERIALS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<Segment>("segments"),
                Binding::read_write::<[u32; 4]>("partials"),
                Binding::texture_read("pairs", Rg32Uint),
                Binding::texture_read("footprints", Rgba32Uint),
                CASTERS,
                SETUPS,
                IMAGES,
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("HAS_QUADS", 1.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const SEEN: [KernelDesc; 2] =
    [seen!(Core, "common/walk_uniform.wgsl"), seen!(Native, "common/walk_subgroup.wgsl")];

macro_rules! surfaces {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "shade_surfaces",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/solid.wgsl",
                "common/gather_seen.wgsl",
                $walk,
                "common/light.wgsl",
                "common/octahedral.wgsl",
                "common/receive.wgsl",
                "common/shading.wgsl",
                "common/surface.wgsl",
                "common/air.wgsl",
                "shade_surfaces.wgsl"
            ],
            bindings: &[
                VIEWS,
                MATERIALS,
                PARAMS,
                LIGHTS,
                SHADOW_VIEWS,
                Binding::read::<Tile>("tiles"),
                Binding::read::<[u32; 4]>("partials"),
                Binding::texture_read("pairs", Rg32Uint),
                Binding::texture_read("footprints", Rgba32Uint),
                CASTERS,
                SETUPS,
                IMAGES,
                TRIANGLES,
                FILTERS,
                NEARESTS,
                OPAQUES,
                Binding::texture_write("surfaces", Rgba32Float),
                AIR,
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("HAS_QUADS", 1.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const SURFACES: [KernelDesc; 2] =
    [surfaces!(Core, "common/walk_uniform.wgsl"), surfaces!(Native, "common/walk_subgroup.wgsl")];

macro_rules! layers {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "shade_layers",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/dispatch.wgsl",
                "common/air.wgsl",
                "common/gather_layers.wgsl",
                $walk,
                "common/light.wgsl",
                "common/octahedral.wgsl",
                "common/receive.wgsl",
                "common/shading.wgsl",
                "common/surface.wgsl",
                "common/sheet.wgsl",
                "shade_layers.wgsl"
            ],
            bindings: &[
                VIEWS,
                MATERIALS,
                PARAMS,
                LIGHTS,
                SHADOW_VIEWS,
                Binding::read::<[u32; 4]>("dispatches"),
                Binding::read::<Segment>("segments"),
                Binding::read_write::<[u32; 4]>("partials"),
                Binding::texture_read("pairs", Rg32Uint),
                Binding::texture_read("footprints", Rgba32Uint),
                CASTERS,
                SETUPS,
                IMAGES,
                TRIANGLES,
                FILTERS,
                NEARESTS,
                OPAQUES,
                Binding::texture("surfaces", FLOAT),
                Binding::texture("lit", FLOAT),
                AIR,
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("HAS_QUADS", 1.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const LAYERS: [KernelDesc; 2] =
    [layers!(Core, "common/walk_uniform.wgsl"), layers!(Native, "common/walk_subgroup.wgsl")];

macro_rules! composite {
    ($tier:ident, $walk:literal) => {
        KernelDesc {
            name: "shade_composite",
            sources: crate::sources![
                "common/record.wgsl",
                "common/view.wgsl",
                "common/material.wgsl",
                "common/tile_rect.wgsl",
                "common/hit.wgsl",
                "common/texture.wgsl",
                "common/caster_hit.wgsl",
                "common/reach.wgsl",
                "common/rows_4.wgsl",
                "common/lane.wgsl",
                "common/tile.wgsl",
                "common/air.wgsl",
                "common/gather_layers.wgsl",
                $walk,
                "common/light.wgsl",
                "common/octahedral.wgsl",
                "common/receive.wgsl",
                "common/shading.wgsl",
                "common/surface.wgsl",
                "common/sheet.wgsl",
                "common/tone.wgsl",
                "shade_composite.wgsl"
            ],
            bindings: &[
                VIEWS,
                MATERIALS,
                PARAMS,
                LIGHTS,
                SHADOW_VIEWS,
                Binding::read::<Tile>("tiles"),
                Binding::read::<[u32; 4]>("partials"),
                Binding::read_write::<u32>("pixels"),
                Binding::texture_read("pairs", Rg32Uint),
                Binding::texture_read("footprints", Rgba32Uint),
                CASTERS,
                SETUPS,
                IMAGES,
                TRIANGLES,
                FILTERS,
                NEARESTS,
                OPAQUES,
                Binding::texture("surfaces", FLOAT),
                Binding::texture("lit", FLOAT),
                AIR,
            ],
            constants: &[
                ("HAS_PARTICLES", 1.0),
                ("HAS_TRIANGLES", 1.0),
                ("HAS_TEXTURES", 1.0),
                ("HAS_PUFFS", 1.0),
                ("HAS_QUADS", 1.0),
            ],
            tier: Tier::$tier,
        }
    };
}
pub const COMPOSITE: [KernelDesc; 2] =
    [composite!(Core, "common/walk_uniform.wgsl"), composite!(Native, "common/walk_subgroup.wgsl")];

pub const CASTERS_LIT: KernelDesc = KernelDesc {
    name: "shade_casters",
    sources: crate::sources![
        "common/record.wgsl",
        "common/view.wgsl",
        "common/light.wgsl",
        "common/receive.wgsl",
        "shade_casters.wgsl"
    ],
    bindings: &[
        PARAMS,
        LIGHTS,
        SHADOW_VIEWS,
        Binding::texture_read("footprints", Rgba32Uint),
        Binding::texture_read("rects", Rg32Uint),
        CASTERS,
        FILTERS,
        NEARESTS,
        OPAQUES,
        Binding::texture_write("lit", Rgba16Float),
    ],
    constants: &[("WORKGROUP_SIZE", CASTER_LANES as f64)],
    tier: Tier::Core,
};

/// WGSL: `wgsl/common/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct GpuLight {
    /// World space [m].
    pub position: Vec3,
    pub kind: u32,
    /// Of travel: unit, world space.
    pub direction: Vec3,
    pub first_view: u32,
    /// Times the intensity.
    pub color: Vec3,
    /// 0: casts no shadow.
    pub view_count: u32,
    /// Cosines of half the angle of a spot: where its light ends, and where it begins to fade.
    pub cone_outer: f32,
    pub cone_inner: f32,
    /// 1 where the air scatters its light.
    pub shafts: u32,
    pub pad_0: u32,
}
crate::gpu_layout!(GpuLight {
    position,
    kind,
    direction,
    first_view,
    color,
    view_count,
    cone_outer,
    cone_inner,
    shafts,
    pad_0
});

impl GpuLight {
    /// `views`: the shadow views of all lights.
    pub fn new(light: &Light, index: usize, views: &[View]) -> Self {
        let own = |view: &View| view.light == Some(index);
        let (kind, position, direction, angle) = match light.kind {
            LightKind::Directional { direction } => (0, Vec3::ZERO, direction, 0.0),
            LightKind::Spot { position, direction, angle } => (1, position, direction, angle),
            LightKind::Point { position } => (2, position, Vec3::NEG_Y, 0.0),
        };
        Self {
            position,
            kind,
            direction,
            first_view: views.iter().position(own).unwrap_or(0) as u32,
            color: light.color * light.intensity,
            view_count: views.iter().filter(|view| own(view)).count() as u32,
            cone_outer: (angle * 0.5).cos(),
            cone_inner: (angle * 0.5 * 0.85).cos(),
            shafts: u32::from(light.shafts),
            pad_0: 0,
        }
    }
}

/// WGSL: `wgsl/common/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PictureParams {
    /// Of the camera.
    pub world_from_view: Mat4,
    pub ambient: Vec3,
    pub light_count: u32,
    pub background: Vec3,
    pub footprint_count: u32,
    /// [m]
    pub bias: f32,
    /// [texels]
    pub normal_bias: f32,
    /// 1 where opaque depths are by channel.
    pub colored: u32,
    /// 0: the air is clear.
    pub air_slices: u32,
}
crate::gpu_layout!(PictureParams {
    world_from_view,
    ambient,
    light_count,
    background,
    footprint_count,
    bias,
    normal_bias,
    colored,
    air_slices
});
