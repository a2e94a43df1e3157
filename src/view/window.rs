//! Windows of directional lights that hold still while casters move: edges and depths in steps, middles on
//! whole texels (Valient 2007, "Stable Rendering of Cascaded Shadow Maps").
use crate::model::Bounds;
use glam::{DVec2, Mat4, Vec3};

/// Steps per octave by which windows around casters grow: few, so that moving casters seldom cross one.
const STEPS: f64 = 4.0;

/// Border on each side of a window: a texel of filtering, half the spline's support and half a texel of
/// snapping \[texels\].
pub(super) const BORDER: f64 = 3.0;

/// Length rounded up in `steps` per octave: products with integers are exact, and rounding errors in the last
/// bit do not change it.
pub(super) fn rounded_up(length: f64, steps: f64) -> f64 {
    let unit = length.log2().floor().exp2() / steps;
    (length / unit).ceil() * unit
}

/// Point moved to the nearest corner of a grid.
pub(super) fn snapped(point: DVec2, texel: f64) -> DVec2 {
    (point / texel + 0.5).floor() * texel
}

/// Edge or depth of a space around moving casters, in steps \[m\].
pub(super) fn stepped(length: f32) -> f32 {
    rounded_up(f64::from(length), STEPS) as f32
}

/// Box in a space that looks along a light's direction, with a margin that keeps its points off a window's
/// border and off depths 0 and 1.
pub(super) struct LightBox {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    pub(super) margin: f32,
}

impl LightBox {
    /// `axes`: world space to the light's.
    pub(super) fn new(axes: &Mat4, bounds: &Bounds) -> Self {
        let corners = bounds.corners().map(|corner| axes.transform_point3(corner));
        Self {
            min: corners.iter().fold(Vec3::INFINITY, |a, &b| a.min(b)),
            max: corners.iter().fold(Vec3::NEG_INFINITY, |a, &b| a.max(b)),
            margin: (bounds.radius() * 0.01).max(1e-4),
        }
    }

    /// Edge of the square window around the box \[m\].
    fn edge(&self) -> f64 {
        f64::from((self.max - self.min).truncate().max_element() + 2.0 * self.margin)
    }

    /// [`Self::edge`] in steps.
    pub(super) fn stepped_edge(&self) -> f64 {
        rounded_up(self.edge(), STEPS)
    }

    /// Texel \[m\] and middle of a window of `size` texels around the box. Snapping moves it by up to half a
    /// texel.
    pub(super) fn window(&self, size: u32) -> (f64, DVec2) {
        let texel = rounded_up(self.edge() / f64::from(size.max(2) - 1), STEPS);
        (texel, snapped((self.min + self.max).as_dvec3().truncate() * 0.5, texel))
    }

    /// z of the plane from which depths are measured, in front of the box; directly in front of it if planes
    /// are `given`.
    pub(super) fn front(&self, given: bool) -> f32 {
        if given {
            return self.max.z + self.margin;
        }
        let depth = f64::from(self.max.z - self.min.z + 2.0 * self.margin);
        let unit = rounded_up(depth, STEPS) / 8.0;
        ((f64::from(self.max.z + self.margin) / unit).ceil() * unit) as f32
    }

    /// Distance of a far plane behind `deepest`, the least z of casters and receivers, from `front` \[m\].
    pub(super) fn far(&self, front: f32, deepest: f32, near: f32) -> f32 {
        let far = stepped(front - deepest + self.margin);
        far.max(near + self.margin.max(near.abs() * 1e-3))
    }
}
