//! Boxes around casters and receivers.
use glam::Vec3;

/// Farthest coordinate of a scene \[m\]: past it neighbouring `f32` are a metre apart.
pub const FARTHEST: f32 = 1e7;

/// An axis-aligned box, world space \[m\]; empty while `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest coordinates \[m\].
    pub min: Vec3,
    /// Highest coordinates \[m\].
    pub max: Vec3,
}

impl Bounds {
    /// The empty box.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box between two corners, world space \[m\].
    pub fn new(min: impl Into<[f32; 3]>, max: impl Into<[f32; 3]>) -> Self {
        Self { min: min.into().into(), max: max.into().into() }
    }

    /// The box grown to hold a sphere \[m\].
    #[must_use]
    pub fn with_sphere(self, center: Vec3, radius: f32) -> Self {
        Self { min: self.min.min(center - radius), max: self.max.max(center + radius) }
    }

    /// The box grown to hold another.
    #[must_use]
    pub fn with(self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether all coordinates are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    /// Whether the box is empty.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The box, or the box around the unit sphere if it is empty: views need some extent.
    #[must_use]
    pub fn or_unit(&self) -> Self {
        if self.is_empty() { Self::EMPTY.with_sphere(Vec3::ZERO, 1.0) } else { *self }
    }

    /// Centre of the box \[m\].
    pub fn center(&self) -> Vec3 {
        (self.min + self.max) * 0.5
    }

    /// Radius of the sphere around the box \[m\].
    pub fn radius(&self) -> f32 {
        (self.max - self.min).length() * 0.5
    }

    /// Half the surface area \[m²\].
    pub fn half_area(&self) -> f32 {
        let edge = self.max - self.min;
        edge.x * edge.y + edge.y * edge.z + edge.z * edge.x
    }

    /// The eight corners \[m\].
    pub fn corners(&self) -> [Vec3; 8] {
        std::array::from_fn(|i| {
            Vec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }
}
