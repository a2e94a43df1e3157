//! Points that ask for light.
use glam::Vec3;

/// A point that asks how much of each light reaches it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReceiverPoint {
    /// World space [m].
    pub position: Vec3,
    /// Normal of the surface that it is on: unit, world space. It lifts the point off that surface's own
    /// shadow, to the light's side. Zero of what is no surface.
    pub normal: Vec3,
}
