//! A view as kernels read it.
use crate::model::{Projection, View, ViewRole};
use glam::{Mat4, UVec2, Vec2};

/// Most views of a batch: the length of the uniform array.
pub const MAX_VIEWS: usize = 256;

/// Numbers of [`ViewRole`] in [`GpuView::role`].
pub const ROLE_WHOLE: u32 = 0;
/// A face of a cube.
pub const ROLE_FACE: u32 = 1;
/// One of several windows: a cascade, or a further shadow.
pub const ROLE_WINDOW: u32 = 2;

crate::records::gpu_struct! {
    /// The part of a [`View`] that kernels read. WGSL: `wgsl/records/view.wgsl`.
    pub struct GpuView {
        pub view_from_world: Mat4,
        /// Size of the map \[texels\].
        pub size: Vec2,
        /// Texels per metre (orthographic), or per metre at 1 m along the axis (perspective).
        pub scale: f32,
        /// 1 for a perspective view, 0 for an orthographic one.
        pub perspective: f32,
        /// Near plane \[m\].
        pub near: f32,
        /// Far plane \[m\].
        pub far: f32,
        /// First of the view's tiles in its batch.
        pub first_tile: u32,
        /// Tiles per row.
        pub tiles_x: u32,
        /// Position of the map in the atlas \[texels\].
        pub origin: UVec2,
        pub layer: u32,
        /// Index of the light; `u32::MAX` for the picture's camera.
        pub light: u32,
        /// [`ROLE_WHOLE`], [`ROLE_FACE`] or [`ROLE_WINDOW`].
        pub role: u32,
        /// Index among the views of its shadow: the cascade, the face.
        pub role_index: u32,
        /// Number of views of its shadow.
        pub role_count: u32,
        /// Width over which a window's border fades \[texels\].
        pub fade: f32,
    }
}

impl View {
    /// The view in kernel form. `first_tile`: index in its batch; `origin` and `layer`: of its map's
    /// rectangle \[texels\].
    pub fn to_gpu(&self, first_tile: u32, origin: UVec2, layer: u32) -> GpuView {
        let (role_index, role_count) = self.role.index_and_count();
        let (role, fade) = match self.role {
            ViewRole::Whole => (ROLE_WHOLE, 0.0),
            ViewRole::Face(_) => (ROLE_FACE, 0.0),
            ViewRole::Window { fade, .. } => {
                (ROLE_WINDOW, fade * 0.5 * self.size.min_element() as f32)
            }
        };
        GpuView {
            view_from_world: self.view_from_world,
            size: self.size.as_vec2(),
            scale: self.scale,
            perspective: f32::from(u8::from(self.projection == Projection::Perspective)),
            near: self.near,
            far: self.far,
            first_tile,
            tiles_x: self.tiles().x,
            origin,
            layer,
            light: self.light.map_or(u32::MAX, |light| light as u32),
            role,
            role_index,
            role_count,
            fade,
        }
    }
}

impl GpuView {
    /// Depth key by distance, the same on all faces of a cube: 0 at the near plane's centre, 1 at the far
    /// plane's corner. `distance`: from the light \[m\].
    pub fn distance_key(&self, distance: f32) -> f32 {
        (distance - self.near) / self.distance_span()
    }

    fn distance_span(&self) -> f32 {
        let corner = self.size * 0.5 / self.scale;
        self.far * (1.0 + corner.length_squared()).sqrt() - self.near
    }
}
