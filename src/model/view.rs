//! Views: shadow cameras, and the picture's camera.
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};

/// Edge of a tile \[texels\]. WGSL: `wgsl/records/view.wgsl`.
pub const TILE_SIZE: u32 = 16;

/// Projection of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Parallel rays along the view axis.
    Orthographic,
    /// Rays from the view's position.
    Perspective,
}

/// Role of a view among those of its shadow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ViewRole {
    /// The only view of its shadow: a cone, or a window on the whole scene.
    #[default]
    Whole,
    /// One of the six faces of a cube: +x, -x, +y, -y, +z, -z.
    Face(u32),
    /// One of several windows, of which the first that contains a point is read: a cascade, or a further
    /// shadow. It fades into the next over `fade` \[share of its half edge\]; beyond the last there is no
    /// shadow.
    Window {
        /// Index among the windows of its shadow.
        index: u32,
        /// Number of windows of its shadow.
        count: u32,
        /// Width of the fade, a share of the window's half edge.
        fade: f32,
    },
}

impl ViewRole {
    /// Index among the views of its shadow, and their number.
    pub fn index_and_count(self) -> (u32, u32) {
        match self {
            Self::Whole => (0, 1),
            Self::Face(index) => (index, 6),
            Self::Window { index, count, .. } => (index, count),
        }
    }
}

/// One shadow camera: a directional view, a spot, or one face of a point light's cube. View space has x
/// right, y up and looks along -z.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Index into [`crate::model::Scene::lights`]; `None` for the picture's camera.
    pub light: Option<usize>,
    /// Name, unique among the views of a light.
    pub name: &'static str,
    /// Role among the views of its shadow.
    pub role: ViewRole,
    /// Projection of its rays.
    pub projection: Projection,
    /// Size of the map \[texels\].
    pub size: UVec2,
    /// First depth along the view axis \[m\]; not below 0 in perspective.
    pub near: f32,
    /// Last depth along the view axis \[m\].
    pub far: f32,
    /// World space to view space: x right, y up, looking along -z \[m\].
    pub view_from_world: Mat4,
    /// Texels per metre (orthographic), or per metre at 1 m along the axis (perspective).
    pub scale: f32,
}

/// Tiles per row and column of a map of `size` texels. Rows have a multiple of four, so that a row of 4-byte
/// texels is a multiple of the 256 bytes that copies require.
pub fn tiles_of(size: UVec2) -> UVec2 {
    let tiles = (size + TILE_SIZE - 1) / TILE_SIZE;
    UVec2::new(tiles.x.next_multiple_of(4), tiles.y)
}

impl View {
    /// Tiles per row and column, by [`tiles_of`].
    pub fn tiles(&self) -> UVec2 {
        tiles_of(self.size)
    }

    /// Position of the light; for an orthographic view the centre of its near plane.
    pub fn position(&self) -> Vec3 {
        let world_from_view = self.view_from_world.inverse();
        match self.projection {
            Projection::Perspective => world_from_view.w_axis.truncate(),
            Projection::Orthographic => {
                world_from_view.transform_point3(Vec3::new(0.0, 0.0, -self.near))
            }
        }
    }

    /// The view axis: unit, world space.
    pub fn direction(&self) -> Vec3 {
        -self.view_from_world.row(2).truncate()
    }

    /// World space to clip space; NDC z in 0..1, nonlinear in depth for a perspective view.
    pub fn clip_from_world(&self) -> Mat4 {
        let half = self.size.as_vec2() * 0.5;
        let (near, far) = (self.near, self.far);
        let clip_from_view = match self.projection {
            Projection::Orthographic => Mat4::from_cols(
                Vec4::new(self.scale / half.x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, self.scale / half.y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, -1.0 / (far - near), 0.0),
                Vec4::new(0.0, 0.0, -near / (far - near), 1.0),
            ),
            Projection::Perspective => Mat4::from_cols(
                Vec4::new(self.scale / half.x, 0.0, 0.0, 0.0),
                Vec4::new(0.0, self.scale / half.y, 0.0, 0.0),
                Vec4::new(0.0, 0.0, far / (near - far), -1.0),
                Vec4::new(0.0, 0.0, near * far / (near - far), 0.0),
            ),
        };
        clip_from_view * self.view_from_world
    }
}

/// Offset of a sample within its pixel \[pixels\]: that of a lens moves the camera's axis by many pixels.
pub fn within_pixel(offset: Vec2) -> Vec2 {
    if offset.abs().max_element() > 1.0 { offset - offset.round() } else { offset }
}
