//! Import of the host's depth maps. WGSL: `wgsl/import/import.wgsl`.
use glam::{Mat4, UVec2, Vec2};

crate::records::gpu_struct! {
    /// Parameters of `import` for one view's depth map.
    pub struct ImportParams {
        /// The host's clip space from our view space.
        pub clip_from_view: Mat4,
        /// Size of our map \[texels\].
        pub size: Vec2,
        /// Size of the host's map \[texels\].
        pub host_size: Vec2,
        /// Same as [`GpuView::scale`](super::GpuView::scale).
        pub scale: f32,
        /// 1 if our view is perspective, 0 if it is orthographic.
        pub perspective: f32,
        /// Near plane of our view \[m\].
        pub near: f32,
        /// Far plane of our view \[m\].
        pub far: f32,
        /// Position of our map in the atlas \[texels\].
        pub origin: UVec2,
        pub layer: u32,
        /// 1: the imported depth replaces that of our own opaque casters.
        pub replaces: u32,
        /// The host's clear depth.
        pub empty: f32,
        pub pad_0: u32,
        pub pad_1: u32,
        pub pad_2: u32,
    }
}
