//! The camera of the picture.
use glam::{UVec2, Vec3};

/// The eye of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// World space [m].
    pub eye: Vec3,
    /// World space [m].
    pub target: Vec3,
    pub up: Vec3,
    /// Vertical field of view [radians].
    pub fov_y: f32,
    /// Of the picture [pixels].
    pub size: UVec2,
}
