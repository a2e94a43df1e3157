//! shade: the lit picture. Surfaces and casters get their light through the shadow maps; casters
//! are laid over the surfaces front to back.
//!
//! In: the camera's lists, the shadow maps. Out: `pixels`. Tiles with more pairs than one segment
//! are walked a segment at a time: `seen` and `layers` leave `partials`, which `surfaces` and
//! `composite` put together in order.
use super::{
    hits::{
        CASTERS, HIT_CONSTANTS, HIT_SOURCES, IMAGES, MATERIALS, OPAQUES, ROLLED, SETUPS, VIEWS,
    },
    walk::{self, DISPATCHES, FOOTPRINTS, LANE_SOURCES, PAIRS, walk_sources},
};
use crate::{
    gpu::{Binding, Constant, FLOAT, KernelDesc, Source, Tier, join, on_each_tier},
    model::{Light, LightKind, View},
    records::GpuView,
};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, UVec3, Vec3};
use wgpu::{
    TextureFormat::{Rg32Uint, Rgba16Float, Rgba32Float},
    TextureSampleType::Uint,
};

/// Lights of a picture. A pixel that asks all of them for its surface and for both panes of its four
/// rows stays below the 65,535 iterations that llvmpipe allows an invocation.
pub const MAX_LIGHTS: usize = 4096;
/// Shadow views of a picture: as many as all lights may have, four shadows of six views each.
pub const MAX_SHADOW_VIEWS: usize = 4 * 6 * MAX_LIGHTS;
/// Texels of a [`GpuLight`]. WGSL: `wgsl/common/light.wgsl`.
pub const LIGHT_TEXELS: u32 = 4;
const _: () = assert!(size_of::<GpuLight>() == LIGHT_TEXELS as usize * 16);
/// Texels of a [`GpuView`]. WGSL: `wgsl/common/light.wgsl`.
pub const VIEW_TEXELS: u32 = 8;
const _: () = assert!(size_of::<GpuView>() == VIEW_TEXELS as usize * 16);
/// Invocations of a workgroup of [`CASTERS_LIT`].
pub const CASTER_LANES: u32 = 64;

pub(super) const PARAMS: Binding = Binding::uniform::<PictureParams>("params");
const AIR: Binding = Binding::texture("air", FLOAT).array();
const TRIANGLES: Binding = Binding::texture("triangles", Uint);
const SURFACES_BELOW: Binding = Binding::texture("surfaces", FLOAT);
const LIT: Binding = Binding::texture("lit", FLOAT);
/// What segments leave, written and read.
const TO_PARTIALS: Binding = Binding::read_write::<[u32; 4]>("partials");
const PARTIALS: Binding = Binding::read::<[u32; 4]>("partials");

/// The lights of a point, and the maps that it gets their light through.
pub(super) const LIGHT_BINDINGS: &[Binding] = &[
    Binding::texture("lights", Uint),
    Binding::texture("clusters", Uint),
    Binding::texture("filters", FLOAT).array(),
    Binding::texture("nearests", FLOAT).array(),
    OPAQUES,
    Binding::texture("curves", Uint).array(),
];
pub(super) const LIGHT_SOURCES: &[Source] = crate::sources![
    "common/light.wgsl",
    "common/curve.wgsl",
    "common/curve_light.wgsl",
    "common/owner.wgsl",
    "common/receiver.wgsl",
    "common/receive.wgsl"
];
pub(super) const LIGHT_CONSTANTS: &[Constant] = &[("NODES", 0.0), ("HAS_GAIN", 0.0)];

/// A walk of the camera's lists.
const SEEN_SOURCES: &[Source] =
    join![Source: HIT_SOURCES, LANE_SOURCES, crate::sources!["common/cost.wgsl"]];
const SEEN_CONSTANTS: &[Constant] =
    join![Constant: HIT_CONSTANTS, &[("HAS_QUADS", 1.0), ("COUNT_COST", 0.0)]];
const SEEN_BINDINGS: &[Binding] = &[PAIRS, FOOTPRINTS, CASTERS, SETUPS, IMAGES];
/// A walk of what is solid.
const SOLID_SOURCES: &[Source] =
    join![Source: SEEN_SOURCES, crate::sources!["common/solid.wgsl", "common/gather_seen.wgsl"]];
/// The light of a surface that is seen.
const SURFACE_SOURCES: &[Source] = join![
    Source: LIGHT_SOURCES,
    crate::sources![
        "common/octahedral.wgsl",
        "common/shading.wgsl",
        "common/surface.wgsl",
        "common/air.wgsl"
    ],
];
/// A walk of what is blended, lit.
const LAYER_SOURCES: &[Source] = join![
    Source: SEEN_SOURCES,
    SURFACE_SOURCES,
    crate::sources![
        "common/volumes.wgsl",
        "common/fog.wgsl",
        "common/gather_layers.wgsl",
        "common/sheet.wgsl"
    ],
];
const LAYER_CONSTANTS: &[Constant] =
    join![Constant: SEEN_CONSTANTS, LIGHT_CONSTANTS, &[("HAS_VOLUMES", 0.0)]];
/// After what is the kernel's own.
const LAYER_BINDINGS: &[Binding] = join![
    Binding: SEEN_BINDINGS,
    &[TRIANGLES],
    LIGHT_BINDINGS,
    &[SURFACES_BELOW, LIT, AIR],
];

pub const SEEN: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "shade_seen",
    sources: join![
        Source: SOLID_SOURCES,
        walk_sources(TIER),
        crate::sources!["common/dispatch.wgsl", "shade_seen.wgsl"],
    ],
    bindings: join![
        Binding: &[VIEWS, MATERIALS, DISPATCHES, walk::SEGMENTS, TO_PARTIALS],
        SEEN_BINDINGS,
    ],
    constants: SEEN_CONSTANTS,
    tier: TIER,
});

pub const SURFACES: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "shade_surfaces",
    sources: join![
        Source: SOLID_SOURCES,
        walk_sources(TIER),
        SURFACE_SOURCES,
        crate::sources!["shade_surfaces.wgsl"],
    ],
    bindings: join![
        Binding: &[VIEWS, MATERIALS, PARAMS, walk::TILES, PARTIALS],
        SEEN_BINDINGS,
        &[TRIANGLES],
        LIGHT_BINDINGS,
        &[Binding::texture_write("surfaces", Rgba32Float), AIR],
    ],
    constants: join![Constant: SEEN_CONSTANTS, LIGHT_CONSTANTS],
    tier: TIER,
});

pub const LAYERS: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "shade_layers",
    sources: join![
        Source: LAYER_SOURCES,
        walk_sources(TIER),
        crate::sources!["common/dispatch.wgsl", "shade_layers.wgsl"],
    ],
    bindings: join![
        Binding: &[VIEWS, MATERIALS, PARAMS, DISPATCHES, walk::SEGMENTS, TO_PARTIALS],
        LAYER_BINDINGS,
    ],
    constants: LAYER_CONSTANTS,
    tier: TIER,
});

pub const COMPOSITE: [KernelDesc; 2] = on_each_tier!(TIER => KernelDesc {
    name: "shade_composite",
    sources: join![
        Source: LAYER_SOURCES,
        walk_sources(TIER),
        crate::sources!["common/tone.wgsl", "shade_composite.wgsl"],
    ],
    bindings: join![
        Binding: &[
            VIEWS,
            MATERIALS,
            PARAMS,
            walk::TILES,
            PARTIALS,
            Binding::read_write::<u32>("pixels"),
        ],
        LAYER_BINDINGS,
    ],
    constants: LAYER_CONSTANTS,
    tier: TIER,
});

pub const CASTERS_LIT: KernelDesc = KernelDesc {
    name: "shade_casters",
    sources: join![
        Source: LIGHT_SOURCES,
        crate::sources![
            "common/record.wgsl",
            "common/view.wgsl",
            "common/material.wgsl",
            "common/rolled.wgsl",
            "shade_casters.wgsl"
        ],
    ],
    bindings: join![
        Binding: &[
            MATERIALS,
            PARAMS,
            FOOTPRINTS,
            Binding::texture_read("rects", Rg32Uint),
            CASTERS,
        ],
        LIGHT_BINDINGS,
        &[Binding::texture_write("lit", Rgba16Float)],
    ],
    constants: join![
        Constant: LIGHT_CONSTANTS,
        &[ROLLED, ("WORKGROUP_SIZE", CASTER_LANES as f64)],
    ],
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
    /// One over the square of the range [1/m^2]; 0 where the light has no end.
    pub per_range2: f32,
    /// 1 where the air scatters its light.
    pub shafts: u32,
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
    per_range2,
    shafts
});

impl GpuLight {
    /// Of all lights; `views`: their shadow views.
    pub fn all(lights: &[Light], views: &[View]) -> Vec<Self> {
        (0..).zip(lights).map(|(index, light)| Self::new(light, index, views)).collect()
    }

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
            per_range2: light.range().map_or(0.0, |range| 1.0 / (range * range)),
            shafts: u32::from(light.shafts),
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
    /// Of the camera [m].
    pub near: f32,
    /// From the camera's near to its far plane [m].
    pub depth_range: f32,
    /// Of the clusters, in x, y and depth.
    pub cells: UVec3,
    /// Edge of a cluster [pixels].
    pub tile: u32,
    /// Where the first slice ends [m].
    pub first_slice: f32,
    pub slices_per_doubling: f32,
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
    near,
    depth_range,
    cells,
    tile,
    first_slice,
    slices_per_doubling,
    colored,
    air_slices
});
