//! The camera of the picture.
use glam::{UVec2, Vec3};

/// The eye of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World space [m].
    pub eye: Vec3,
    /// World space [m].
    pub target: Vec3,
    /// Upwards in the picture, about; world space.
    pub up: Vec3,
    /// Vertical field of view [radians].
    pub fov_y: f32,
    /// Size of the picture [pixels].
    pub size: UVec2,
}

impl Default for Camera {
    /// 45 degrees wide in height, from the side and above towards the origin.
    fn default() -> Self {
        Self {
            eye: Vec3::new(4.0, 3.0, 6.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov_y: std::f32::consts::FRAC_PI_4,
            size: UVec2::new(960, 540),
        }
    }
}
