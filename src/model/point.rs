//! Receivers as points.
use glam::Vec3;

/// A receiver: a point at which the light that arrives is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReceiverPoint {
    /// Position, world space \[m\].
    pub position: Vec3,
    /// Normal of its surface, unit, world space. It offsets the point towards the light, off the surface's
    /// own shadow. Zero if it is on no surface.
    pub normal: Vec3,
}
