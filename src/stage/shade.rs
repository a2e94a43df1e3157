//! shade: the lit picture. Surfaces and casters get their light through the shadow maps; casters
//! are laid over the surfaces front to back.
//!
//! In: the camera's lists, the shadow maps. Out: `pixels`. Tiles with more pairs than one segment
//! are walked a segment at a time: `seen` and `layers` leave `partials`, which `surfaces` and
//! `composite` put together in order.
use super::walk::{ROWS_4, WALK};
use crate::gpu::{Choice, KernelDesc, Tier};
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, UVec3, Vec3};

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
