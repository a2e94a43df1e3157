//! Conversion of a view's maps to a layout of the host. WGSL: `wgsl/import/import.wgsl`.
use glam::{Mat4, UVec2, Vec2};

/// Numbers of the host's formats.
pub const FORMAT_RGBA16FLOAT: u32 = 0;
/// `rgba8unorm`.
pub const FORMAT_RGBA8UNORM: u32 = 1;
/// `rg11b10ufloat`.
pub const FORMAT_RG11B10UFLOAT: u32 = 2;

crate::records::gpu_struct! {
    /// Parameters of `convert` for one view.
    pub struct ConvertParams {
        /// The host's clip space from our view space.
        pub clip_from_view: Mat4,
        /// Size of the map \[texels\].
        pub size: Vec2,
        /// Same as [`GpuView::scale`](super::GpuView::scale).
        pub scale: f32,
        /// 1 for a perspective view, 0 for an orthographic one.
        pub perspective: f32,
        /// Near plane \[m\].
        pub near: f32,
        /// Far plane \[m\].
        pub far: f32,
        /// Position of the map in the atlas \[texels\].
        pub origin: UVec2,
        pub layer: u32,
        /// Width of the atlas \[texels\].
        pub width: u32,
        /// 1: alpha is the host's depth of the nearest translucent hit.
        pub has_depth: u32,
        /// Alpha without a translucent hit.
        pub empty: f32,
    }
}
