//! Shadow views of lights: fitted to camera and casters, sized by their importance in the picture.
pub mod atlas;
mod cascades;
mod cover;
mod curve_budget;
pub(crate) use curve_budget::NODE_BYTES;
mod detail;
mod fit;
mod held;
mod importance;
mod raster;
mod receivers;
mod soft;
mod window;

pub use cascades::splits;
pub use detail::picture_views;
pub use fit::{fitted_views, light_views, shadow_views, views_around};
pub use held::HeldBounds;
pub use receivers::Receivers;

use crate::model::{Bounds, Camera, Projection, Scene, View, ViewRole, within_pixel};
use fit::{depth_range, looking};
use glam::{Mat4, Vec2, Vec4};

impl View {
    /// The picture's camera; its near and far planes enclose `bounds`.
    pub fn from_camera(camera: &Camera, bounds: &Bounds) -> Self {
        let view_from_world =
            looking(camera.eye, (camera.target - camera.eye).normalize(), camera.up);
        let (_, farthest) = depth_range(&view_from_world, &bounds.or_unit());
        // A floor seen from straight above must not be at the far plane, which is the sky.
        let far = farthest * 1.001;
        let near = (far * 1e-4).max(1e-4);
        Self {
            light: None,
            name: "camera",
            role: ViewRole::Whole,
            projection: Projection::Perspective,
            size: camera.size,
            near,
            far: far.max(near * 2.0),
            view_from_world,
            scale: camera.size.y as f32 * 0.5 / (camera.fov_y * 0.5).tan(),
        }
    }

    /// The camera's view jittered within its pixels: the point that projects `offset` \[pixels\] right and
    /// below a pixel's centre projects to the centre.
    #[must_use]
    pub fn through(self, offset: Vec2) -> Self {
        let aside = offset / self.scale;
        // View-space z is negative along the axis.
        let shear =
            Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::new(aside.x, -aside.y, 1.0, 0.0), Vec4::W);
        Self { view_from_world: shear * self.view_from_world, ..self }
    }

    /// The camera's view through a point on its lens \[m\], to the right and up: points at the distance
    /// `focus` along the axis keep their place in the picture.
    #[must_use]
    pub fn through_lens(self, point: Vec2, focus: f32) -> Self {
        let slope = -point / focus;
        let aside = Mat4::from_cols(
            Vec4::X,
            Vec4::Y,
            Vec4::new(slope.x, slope.y, 1.0, 0.0),
            Vec4::new(-point.x, -point.y, 0.0, 1.0),
        );
        Self { view_from_world: aside * self.view_from_world, ..self }
    }

    /// Offset given to [`Self::through`] \[pixels\]; through a lens, more.
    pub fn shear(&self) -> Vec2 {
        let [right, up, back] = [0, 1, 2].map(|row| self.view_from_world.row(row).truncate());
        Vec2::new(right.dot(back), -up.dot(back)) * self.scale
    }

    /// Offset given to [`Self::through`] \[pixels\], or the one within a pixel that belongs to its point on
    /// the lens.
    pub fn sample_offset(&self) -> Vec2 {
        within_pixel(self.shear())
    }

    /// The views of a scene's camera through each of its samples. `whole`: [`Self::from_camera`].
    pub fn of_samples(scene: &Scene, whole: &Self) -> impl Iterator<Item = Self> {
        let focus = scene.lens.focus;
        let focus = focus.unwrap_or_else(|| scene.camera.eye.distance(scene.camera.target));
        let has_lens = scene.lens.radius > 0.0;
        scene.sample_offsets().zip(scene.lens_points()).map(move |(offset, point)| {
            let view = whole.clone().through(offset);
            if has_lens { view.through_lens(point, focus) } else { view }
        })
    }
}
