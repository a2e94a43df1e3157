//! Area of a light: the surface that its rays leave.
use super::LightKind;
use glam::Vec3;
use std::f32::consts::PI;

/// The surface that a light's rays leave, of uniform emission. The light at a receiver is the mean over the
/// points of the surface that the receiver sees. A source of size 0 is the same as none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Source {
    /// A sphere around the position of a spot or point light.
    Sphere {
        /// [m]
        radius: f32,
    },
    /// A disc around the position of a spot or point light.
    Disc {
        /// [m]
        radius: f32,
        /// Direction that the emitting side faces: world space, any length.
        direction: Vec3,
    },
    /// A rectangle around the position of a spot or point light.
    Rect {
        /// Edge along `cross(direction, up)` [m]; up is +y, or +z where the direction is within 8 degrees
        /// of y.
        width: f32,
        /// Edge across the width [m].
        height: f32,
        /// Direction that the emitting side faces: world space, any length.
        direction: Vec3,
    },
    /// A sun, for directional lights only.
    Sun {
        /// Angular diameter [radians].
        angle: f32,
    },
}

/// Largest size of a source [m].
pub const MAX_SOURCE_SIZE: f32 = 1e4;
/// Largest angle of a sun [radians].
pub const MAX_SUN_ANGLE: f32 = PI / 3.0;

impl Source {
    /// Whether it has no size.
    pub fn is_point(&self) -> bool {
        match *self {
            Self::Sphere { radius } | Self::Disc { radius, .. } => radius == 0.0,
            Self::Rect { width, height, .. } => width == 0.0 && height == 0.0,
            Self::Sun { angle } => angle == 0.0,
        }
    }

    /// Half axes of the disc with the variance of the source: the radius of a disc or sphere, the edges of
    /// a rectangle divided by the square root of 3 [m]; of a sun, the tangent of half its angle.
    pub fn half_axes(&self) -> [Vec3; 2] {
        let (sizes, direction) = match *self {
            Self::Disc { radius, direction } => ([radius; 2], direction),
            Self::Rect { width, height, direction } => {
                ([width, height].map(|edge| edge / 3f32.sqrt()), direction)
            }
            Self::Sphere { radius } => return [Vec3::X * radius, Vec3::ZERO],
            Self::Sun { angle } => return [Vec3::X * (0.5 * angle).tan(), Vec3::ZERO],
        };
        let along = direction.as_dvec3().normalize_or(glam::DVec3::NEG_Y).as_vec3();
        let up = if along.y.abs() > 0.99 { Vec3::Z } else { Vec3::Y };
        let right = along.cross(up).normalize();
        [right * sizes[0], right.cross(along) * sizes[1]]
    }

    pub(super) fn problem(&self, kind: &LightKind) -> Option<&'static str> {
        let is_sun = matches!(self, Self::Sun { .. });
        if is_sun != matches!(kind, LightKind::Directional { .. }) {
            return Some(
                "a sun is the source of a directional light, the others are of the others",
            );
        }
        let size = |v: f32| (0.0..=MAX_SOURCE_SIZE).contains(&v);
        let is_sized = match *self {
            Self::Sphere { radius } | Self::Disc { radius, .. } => size(radius),
            Self::Rect { width, height, .. } => size(width) && size(height),
            Self::Sun { angle } => (0.0..=MAX_SUN_ANGLE).contains(&angle),
        };
        if !is_sized {
            return Some("the size of its source must be finite, not negative and not too large");
        }
        match *self {
            Self::Disc { direction, .. } | Self::Rect { direction, .. } => {
                let faces = direction.is_finite() && direction != Vec3::ZERO;
                (!faces).then_some("the direction of its source must be finite and not zero")
            }
            Self::Sphere { .. } | Self::Sun { .. } => None,
        }
    }
}
