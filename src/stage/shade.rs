//! shade: the lit picture. Surfaces and casters get their light through the shadow maps; casters
//! are laid over the surfaces front to back.
//!
//! In: the camera's lists, the shadow maps. Out: `pixels`. Tiles with more pairs than one segment
//! are walked a segment at a time: `seen` and `layers` leave `partials`, which `surfaces` and
//! `composite` put together in order.
use super::walk::{ROWS_4, WALK};
use crate::{
    gpu::{Choice, KernelDesc, Tier},
    model::{Light, LightKind, View},
    records::GpuView,
};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, UVec3, Vec3};

/// Lights of a picture. A pixel that asks all of them for its surface and for both panes of its four
/// rows stays below the 65,535 iterations that llvmpipe allows an invocation.
pub const MAX_LIGHTS: usize = 4096;
/// Shadow views of a picture: as many as all lights may have, four shadows of six views each.
pub const MAX_SHADOW_VIEWS: usize = 4 * 6 * MAX_LIGHTS;
/// Texels of a [`GpuLight`]. WGSL: `wgsl/records/light.wgsl`.
pub const LIGHT_TEXELS: u32 = 4;
const _: () = assert!(size_of::<GpuLight>() == LIGHT_TEXELS as usize * 16);
/// Texels of a [`GpuView`]. WGSL: `wgsl/records/light.wgsl`.
pub const VIEW_TEXELS: u32 = 8;
const _: () = assert!(size_of::<GpuView>() == VIEW_TEXELS as usize * 16);
/// Invocations of a workgroup of [`CASTERS_LIT`].
pub const CASTER_LANES: u32 = 64;

/// The nearest solid caster of four pixels.
const SEEN_STATE: Choice = Choice::new("state", "state/seen.wgsl");
/// What is laid over four pixels.
const LAYER_STATE: Choice = Choice::new("state", "state/layers.wgsl");

pub const SEEN: KernelDesc = KernelDesc {
    name: "shade_seen",
    root: "shade/shade_seen.wgsl",
    with: &[ROWS_4, SEEN_STATE, WALK],
    constants: &[],
    tiers: Tier::ALL,
};

pub const SURFACES: KernelDesc = KernelDesc {
    name: "shade_surfaces",
    root: "shade/shade_surfaces.wgsl",
    with: &[ROWS_4, SEEN_STATE, WALK],
    constants: &[],
    tiers: Tier::ALL,
};

pub const LAYERS: KernelDesc = KernelDesc {
    name: "shade_layers",
    root: "shade/shade_layers.wgsl",
    with: &[ROWS_4, LAYER_STATE, WALK],
    constants: &[],
    tiers: Tier::ALL,
};

pub const COMPOSITE: KernelDesc = KernelDesc {
    name: "shade_composite",
    root: "shade/shade_composite.wgsl",
    with: &[ROWS_4, LAYER_STATE, WALK],
    constants: &[],
    tiers: Tier::ALL,
};

pub const CASTERS_LIT: KernelDesc = KernelDesc {
    name: "shade_casters",
    root: "shade/shade_casters.wgsl",
    with: &[],
    constants: &[("WORKGROUP_SIZE", CASTER_LANES as f64)],
    tiers: &[Tier::Core],
};

/// WGSL: `wgsl/records/light.wgsl`.
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

/// WGSL: `wgsl/records/light.wgsl`.
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
    /// Light is shown so much brighter.
    pub exposure: f32,
    /// Of a pixel: what is shown, and where there are 3, its linear light as half floats.
    pub pixel_words: u32,
    pub pad_0: u32,
    pub pad_1: u32,
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
    air_slices,
    exposure,
    pixel_words,
    pad_0,
    pad_1
});
