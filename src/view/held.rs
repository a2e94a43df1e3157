//! Bounds of moving casters that a host holds from frame to frame.
use crate::model::Bounds;
use glam::Vec3;

/// Room at each side of a new box, as a share of its radius.
const ROOM: f32 = 0.125;
/// Ratio of a held box's radius to its contents' past which it is made anew.
const TOO_LARGE: f32 = 2.5;

/// A box around casters and receivers that move, for [`light_views`](crate::light_views). It stays the same
/// while they are in it and fill a fair part of it, so that the views do, too, and everything at rest has the
/// same shadow in each frame.
///
/// ```
/// use gobo::{Bounds, HeldBounds, Light, glam::Vec3, light_views};
///
/// let mut held = HeldBounds::default();
/// let sun = Light::directional(Vec3::NEG_Y);
/// let mut frame = |x: f32| {
///     let casters = Bounds::new([-4.0, 0.0, -4.0], [x, 2.0, 4.0]);
///     light_views(0, &sun, 1024, None, &held.hold(&casters))
/// };
/// assert_eq!(frame(4.0)?, frame(4.3)?);
/// # Ok::<(), gobo::model::InvalidLight>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeldBounds {
    held: Option<Bounds>,
}

impl HeldBounds {
    /// The box for a frame with these casters and receivers, world space \[m\]: the former one, or a new one
    /// with some room around them. Bounds that are empty or not finite are returned unchanged.
    pub fn hold(&mut self, bounds: &Bounds) -> Bounds {
        if bounds.is_empty() || !bounds.is_finite() {
            return *bounds;
        }
        let fits = |held: &Bounds| {
            held.with(bounds) == *held && held.radius() <= TOO_LARGE * bounds.radius()
        };
        let held = self.held.filter(fits).unwrap_or_else(|| roomy(bounds));
        *self.held.insert(held)
    }
}

fn roomy(bounds: &Bounds) -> Bounds {
    let room = Vec3::splat(bounds.radius() * ROOM);
    Bounds { min: bounds.min - room, max: bounds.max + room }
}
