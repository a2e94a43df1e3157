//! A depth map of the host's. WGSL: `wgsl/records/import.wgsl`.
use bytemuck::{Pod, Zeroable};
use glam::{Mat4, UVec2, Vec2};

/// What `import` needs of a depth map of the host's, of one view.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ImportParams {
    /// The host's camera, from our view space.
    pub clip_from_view: Mat4,
    /// Size of our map [texels].
    pub size: Vec2,
    /// Size of the host's [texels].
    pub host_size: Vec2,
    /// As in [`GpuView`](super::GpuView).
    pub scale: f32,
    /// 1 or 0, of our view.
    pub perspective: f32,
    /// [m]
    pub near: f32,
    /// [m]
    pub far: f32,
    /// In the atlas [texels].
    pub origin: UVec2,
    pub layer: u32,
    /// 1: what our own opaque casters left does not count.
    pub replaces: u32,
    /// The host's depth where there is nothing.
    pub empty: f32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}
crate::gpu_layout!(ImportParams {
    clip_from_view,
    size,
    host_size,
    scale,
    perspective,
    near,
    far,
    origin,
    layer,
    replaces,
    empty,
    pad_0,
    pad_1,
    pad_2
});
