//! Area of a light: the surface that its rays leave.
use super::LightKind;
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// The surface that a light's rays leave, of uniform emission. The light at a receiver is the mean over the
/// points of the surface that the receiver sees. A source of size 0 acts as a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A sphere around the position of a spot or point light.
    Sphere {
        /// \[m\]
        radius: f32,
    },
    /// A disc around the position of a spot or point light.
    Disc {
        /// \[m\]
        radius: f32,
        /// Direction that the emitting side faces: world space, any length.
        direction: Vec3,
    },
    /// A rectangle around the position of a spot or point light.
    Rect {
        /// Edge along `cross(direction, up)` \[m\]; up is +y, or +z where the direction is y or -y.
        width: f32,
        /// Edge across the width \[m\].
        height: f32,
        /// Direction that the emitting side faces: world space, any length.
        direction: Vec3,
    },
    /// A sun, for directional lights only.
    Sun {
        /// Angular diameter \[radians\].
        angle: f32,
    },
}

/// Largest size of a source \[m\].
pub const MAX_SOURCE_SIZE: f32 = 1e4;
/// Largest angle of a sun \[radians\].
pub const MAX_SUN_ANGLE: f32 = PI / 3.0;
/// Most parts of a source that have maps of their own.
pub const MAX_VIEWPOINTS: u32 = 9;
impl Source {
    /// Whether the source has no size.
    pub fn is_point(&self) -> bool {
        match *self {
            Self::Sphere { radius } | Self::Disc { radius, .. } => radius == 0.0,
            Self::Rect { width, height, .. } => width == 0.0 && height == 0.0,
            Self::Sun { angle } => angle == 0.0,
        }
    }

    /// Half axes of the disc with the variance of the source: for a disc or sphere its radius, for a
    /// rectangle its edges divided by the square root of 3 \[m\]; for a sun, the tangent of half its angle.
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
        let up = if Self::is_upright(along) { Vec3::Z } else { Vec3::Y };
        let right = along.cross(up).normalize();
        [right * sizes[0], right.cross(along) * sizes[1]]
    }

    /// Whether a direction is y or -y up to rounding.
    pub fn is_upright(direction: Vec3) -> bool {
        direction.x.hypot(direction.z) < 1e-5 * direction.length()
    }

    /// Share of a round source's variance that the middles of its parts have. The parts of a sphere overlap,
    /// so that thin bars before them do not cast four shadows.
    fn spread(&self, count: u32) -> f32 {
        let apart = 1.0 - 1.0 / count as f32;
        if matches!(self, Self::Sphere { .. }) { 0.85 * apart } else { apart }
    }

    /// One of `count` equal parts.
    pub(crate) fn part(&self, count: u32) -> Self {
        let smaller = (1.0 - self.spread(count)).sqrt();
        match *self {
            Self::Sphere { radius } => Self::Sphere { radius: radius * smaller },
            Self::Disc { radius, direction } => Self::Disc { radius: radius * smaller, direction },
            Self::Rect { width, height, direction } => {
                let [columns, rows] = grid(width, height, count).map(|parts| parts as f32);
                Self::Rect { width: width / columns, height: height / rows, direction }
            }
            Self::Sun { angle } => {
                Self::Sun { angle: 2.0 * ((0.5 * angle).tan() * smaller).atan() }
            }
        }
    }

    /// Middle of one of `count` parts, in units of the source's [`Self::half_axes`]. The parts of a round
    /// source form a ring, from six parts on around a middle one: together they have the area and the
    /// variance of the whole.
    pub(super) fn part_middle(&self, count: u32, index: u32) -> Vec2 {
        if let Self::Rect { width, height, .. } = *self {
            let [columns, rows] = grid(width, height, count);
            let along =
                |i: u32, parts: u32| 0.75f32.sqrt() * ((2 * i + 1) as f32 / parts as f32 - 1.0);
            return Vec2::new(along(index % columns, columns), along(index / columns, rows));
        }
        let inner = u32::from(count > 5);
        let ring = (count - inner) as f32;
        let variance = 0.25 * self.spread(count);
        let radius = (2.0 * variance * count as f32 / ring).sqrt();
        let angle = TAU * ((index + 1 - inner) as f32 - 0.75) / ring;
        if index < inner { Vec2::ZERO } else { Vec2::from_angle(angle) * radius }
    }

    /// Middle of one of `count` parts of a point light's source, from the middle of the whole, world space
    /// \[m\]. The parts of a sphere form a tetrahedron or a cube: from every side they have the sphere's
    /// variance.
    pub(super) fn part_place(&self, count: u32, index: u32) -> Vec3 {
        let Self::Sphere { radius } = *self else {
            let [right, up] = self.half_axes();
            let Vec2 { x, y } = self.part_middle(count, index);
            return right * x + up * y;
        };
        let sign = |bit: u32| if index >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let third = if count == 4 { sign(0) * sign(1) } else { sign(2) };
        let corner = Vec3::new(sign(0), sign(1), third).normalize();
        corner * radius * (0.75 * self.spread(count)).sqrt()
    }

    /// The disc that a spot's receivers see of a sphere; other sources unchanged.
    pub(super) fn facing(&self, direction: Vec3) -> Self {
        match *self {
            Self::Sphere { radius } => Self::Disc { radius, direction },
            source => source,
        }
    }

    /// Reason why a light of this kind and source cannot be cut into `count` parts; `None` if it can.
    pub fn parts_problem(&self, kind: &LightKind, count: u32) -> Option<&'static str> {
        let is_round = !matches!(self, Self::Rect { .. });
        match (kind, count) {
            (_, 0 | 1) => None,
            _ if !(1..=MAX_VIEWPOINTS).contains(&count) => Some("it must have 1 to 9 viewpoints"),
            (LightKind::Point { .. }, 4 | 8) => None,
            (LightKind::Point { .. }, _) if matches!(self, Self::Sphere { .. }) => {
                Some("a sphere of a point light must have 1, 4 or 8 viewpoints")
            }
            (_, 2) if is_round => Some("a round source must have 1 or 3 to 9 viewpoints"),
            _ => None,
        }
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

/// Columns and rows of `count` equal parts of a rectangle, with edges as equal as possible.
fn grid(width: f32, height: f32, count: u32) -> [u32; 2] {
    let length = |columns: &u32| {
        let (x, y) = (width / *columns as f32, height / (count / columns) as f32);
        x.max(y)
    };
    let columns = (1..=count).filter(|columns| count.is_multiple_of(*columns));
    let best = columns.min_by(|a, b| length(a).total_cmp(&length(b))).unwrap_or(1);
    [best, count / best]
}
