//! The views of lights: fitted to camera and casters, sized by what the picture shows of them.
pub mod atlas;
mod cascades;
mod cover;
mod fit;
mod importance;

pub use cascades::splits;
pub use fit::{fitted_views, light_views, shadow_views, views_around};

use crate::model::{Bounds, Camera, Part, Projection, View};
use fit::{depth_range, looking};
use glam::{Mat4, Vec2, Vec4};

impl View {
    /// The picture's camera; near and far enclose `bounds`.
    pub fn from_camera(camera: &Camera, bounds: &Bounds) -> Self {
        let view_from_world =
            looking(camera.eye, (camera.target - camera.eye).normalize(), camera.up);
        let (_, farthest) = depth_range(&view_from_world, &bounds.or_unit());
        // A floor that is seen from straight above must not lie on the plane, where the sky is.
        let far = farthest * 1.001;
        let near = (far * 1e-4).max(1e-4);
        Self {
            light: None,
            name: "camera",
            part: Part::Whole,
            projection: Projection::Perspective,
            size: camera.size,
            near,
            far: far.max(near * 2.0),
            view_from_world,
            scale: camera.size.y as f32 * 0.5 / (camera.fov_y * 0.5).tan(),
        }
    }

    /// A camera's view through another place of its pixels: what lies `offset` [pixels] right and below
    /// a pixel's middle is in the middle.
    #[must_use]
    pub fn through(self, offset: Vec2) -> Self {
        let aside = offset / self.scale;
        // Along the axis z is negative.
        let shear =
            Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::new(aside.x, -aside.y, 1.0, 0.0), Vec4::W);
        Self { view_from_world: shear * self.view_from_world, ..self }
    }
}
