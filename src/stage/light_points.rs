//! light points: the share of each light that reaches each point of a host.
//!
//! In: points, the shadow maps. Out: `point_shares`. In `gobo-picture` the same entry point evaluates the
//! light that points of a picture send to the eye.
use super::{
    caustics,
    levels::{OF_AREA, OF_POINT},
    walk::IN_ORDER,
};
use crate::{
    gpu::{Choice, Constant, KernelDesc},
    model::IRRADIANCE,
};
use glam::{Mat4, UVec3, Vec2, Vec3, Vec4};

/// Workgroup size of kernels over points or footprints.
pub const POINT_LANES: u32 = 64;
/// No list: all points of a batch are evaluated.
pub const NO_LIST: u32 = u32::MAX;
/// Pairs of a tile that one round walks: together with the panes blended on the way, an invocation stays
/// below the 65,535 iterations that llvmpipe allows it. WGSL: `crates/gobo-picture/wgsl/shade/band.wgsl`.
pub const ROUND_LENGTH: u32 = 16384;

/// Constants of kernels over points.
pub const LANES: &[Constant] = &[("WORKGROUP_SIZE", POINT_LANES as f64)];
const ROOT: &str = "shade/light_points.wgsl";
const SHARES: Choice = Choice::new("light_output", "shade/light_through.wgsl");

/// A kernel over points or footprints, one invocation each.
pub const fn of_points(kernel: KernelDesc) -> KernelDesc {
    KernelDesc { shared: &[IN_ORDER], constants: LANES, ..kernel }
}

/// Share of each light that reaches the points of a host.
pub const LIGHT_SHARES: KernelDesc = KernelDesc {
    name: "light_shares",
    entry: "light_points",
    with: &[SHARES, OF_POINT, caustics::STRAIGHT],
    ..of_points(KernelDesc::new("light_points", ROOT))
};
/// [`LIGHT_SHARES`] with area lights.
pub const AREA_LIGHT_SHARES: KernelDesc = KernelDesc {
    name: "area_light_shares",
    with: &[SHARES, OF_AREA, caustics::STRAIGHT],
    ..LIGHT_SHARES
};
/// [`LIGHT_SHARES`] with light that glass throws.
pub const THROWN_LIGHT_SHARES: KernelDesc = KernelDesc {
    name: "thrown_light_shares",
    with: &[SHARES, OF_POINT, caustics::THROWN],
    ..LIGHT_SHARES
};
/// [`AREA_LIGHT_SHARES`] with light that glass throws.
pub const THROWN_AREA_LIGHT_SHARES: KernelDesc = KernelDesc {
    name: "thrown_area_light_shares",
    with: &[SHARES, OF_AREA, caustics::THROWN],
    ..LIGHT_SHARES
};

/// The kernel that gives a host the share of each light.
pub fn light_shares(area: bool, thrown: bool) -> &'static KernelDesc {
    match [area, thrown] {
        [false, false] => &LIGHT_SHARES,
        [true, false] => &AREA_LIGHT_SHARES,
        [false, true] => &THROWN_LIGHT_SHARES,
        [true, true] => &THROWN_AREA_LIGHT_SHARES,
    }
}

/// Workgroup grid for `count` points or footprints.
pub fn point_grid(count: u32) -> [u32; 3] {
    const ROW: u32 = 32768;
    let groups = count.div_ceil(POINT_LANES);
    [groups.min(ROW), groups.div_ceil(ROW), 1]
}

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/light.wgsl`.
    #[derive(Eq)]
    pub struct PointBatch {
        /// First entry of the list; without a list the first point of `lit`, or the first caster.
        pub first: u32,
        /// Number of answers without a list.
        pub count: u32,
        /// 1 if the host's points have normals, else 0.
        pub has_normals: u32,
        /// A list of a picture, or [`NO_LIST`].
        pub list: u32,
        /// For points in bricks: first texel of their grid's record.
        pub grid: u32,
        /// 1 where the voxels of their own brick shadow them.
        pub own_shadow: u32,
    }
}

impl PointBatch {
    /// Points without a list.
    pub fn of(first: u32, count: u32) -> Self {
        Self { first, count, has_normals: 0, list: NO_LIST, grid: 0, own_shadow: 0 }
    }
}

crate::records::gpu_struct! {
    /// WGSL: `wgsl/records/light.wgsl`.
    pub struct PictureParams {
        /// The camera's view to world.
        pub world_from_view: Mat4,
        pub ambient: Vec3,
        pub light_count: u32,
        pub background: Vec3,
        /// Footprint of the first triangle with a setup.
        pub first_setup: u32,
        /// Factor of the light before the tone curve.
        pub exposure: f32,
        /// Texel of `lights` where areas begin.
        pub first_area: u32,
        /// Near plane of the camera \[m\].
        pub near: f32,
        /// Distance from the camera's near to its far plane \[m\].
        pub depth_range: f32,
        /// Number of clusters in x, y and depth.
        pub cells: UVec3,
        /// Edge of a cluster \[pixels\].
        pub tile: u32,
        /// End of the first slice \[m\].
        pub first_slice: f32,
        pub slices_per_doubling: f32,
        /// 1: opaque depths are per channel.
        pub colored: u32,
        /// Slices of the air; 0 without air.
        pub air_slices: u32,
        /// [`Tone`](crate::model::Tone).
        pub tone: u32,
        /// Share of the light that spreads.
        pub bloom: f32,
        /// Radius around a surface in which others occlude ambient light \[m\].
        pub occlusion_radius: f32,
        /// Added to it, times the distance along the axis.
        pub occlusion_radius_per_distance: f32,
        /// Extinction of the air \[1/m\].
        pub extinction: Vec3,
        /// Edge of the sharp level of the environment \[texels\].
        pub environment_size: u32,
        /// [`ImageDetail::reach`](crate::records::ImageDetail::reach).
        pub image_reach: f32,
        /// [`ImageDetail::threshold`](crate::records::ImageDetail::threshold).
        pub cutout_threshold: f32,
        /// Offset of the sample in its pixel from the first sample's \[pixels\].
        pub from_first: Vec2,
        /// Offset of the second sample from the first \[pixels\].
        pub second_from_first: Vec2,
        pub pad_0: u32,
        pub pad_1: u32,
        /// Irradiance of the environment as spherical harmonics (rgb).
        pub irradiance: [Vec4; IRRADIANCE],
    }
}
