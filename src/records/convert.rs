//! A view's maps in a layout of the host's. WGSL: `wgsl/records/convert.wgsl`.
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, UVec2, Vec2};

/// Numbers of formats.
pub const FORMAT_RGBA16FLOAT: u32 = 0;
pub const FORMAT_RGBA8UNORM: u32 = 1;
pub const FORMAT_RG11B10UFLOAT: u32 = 2;

/// What `convert` needs of a view.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ConvertParams {
    /// The host's camera, from our view space.
    pub clip_from_view: Mat4,
    /// Size of the map [texels].
    pub size: Vec2,
    /// As in [`GpuView`](super::GpuView).
    pub scale: f32,
    /// 1 or 0.
    pub perspective: f32,
    /// [m]
    pub near: f32,
    /// [m]
    pub far: f32,
    /// In the atlas [texels].
    pub origin: UVec2,
    pub layer: u32,
    /// Width of the atlas [texels].
    pub width: u32,
    /// 1: alpha is the host's depth of what filters first.
    pub has_depth: u32,
    /// Alpha where nothing filters.
    pub empty: f32,
}
crate::gpu_layout!(ConvertParams {
    clip_from_view,
    size,
    scale,
    perspective,
    near,
    far,
    origin,
    layer,
    width,
    has_depth,
    empty
});
