//! The planes of a view.
use crate::{model::Bounds, records::GpuView};
use glam::{DVec3, Vec3, Vec4};

/// Rounding error of the transform of a point in `project`, as a share of its largest coordinate: some ten
/// operations of 2^-24 each, and a root of their sum where a sphere almost contains the eye.
pub const ROUNDING: f32 = 1.0 / (1 << 18) as f32;
/// Tolerance for a view's axes that are not quite unit and orthogonal.
const SKEW: f64 = 1e-5;
/// Enlargement of boxes for the tolerance of a view's axes, as a share of their size.
pub const SKEWED: f32 = 2e-5;

/// Four planes as structure of arrays; inside is where `x n.x + y n.y + z n.z + d >= 0`.
#[derive(Clone, Copy, Debug)]
struct Planes {
    x: Vec4,
    y: Vec4,
    z: Vec4,
    d: Vec4,
    /// Absolute values of `x`, `y` and `z`.
    sizes: [Vec4; 3],
}

impl Planes {
    fn new(planes: [(DVec3, f64); 4]) -> Self {
        let lanes = |of: fn(&(DVec3, f64)) -> f64| {
            Vec4::from_array(planes.each_ref().map(|plane| of(plane) as f32))
        };
        let [x, y, z] = [lanes(|p| p.0.x), lanes(|p| p.0.y), lanes(|p| p.0.z)];
        Self { x, y, z, d: lanes(|p| p.1), sizes: [x, y, z].map(Vec4::abs) }
    }

    /// Distance of the centre, and extent of the box, along each plane's normal.
    #[inline]
    fn test(&self, center: Vec3, half: Vec3) -> (Vec4, Vec4) {
        let distance = self.x * center.x + self.y * center.y + self.z * center.z + self.d;
        let [x, y, z] = self.sizes;
        let reach = x * half.x + y * half.y + z * half.z;
        (distance, reach)
    }
}

/// Flags of the planes that a box may still cross: those that its parent's box crosses.
pub(super) const CROSSES_SIDES: u8 = 1;
pub(super) const CROSSES_DEPTHS: u8 = 2;
pub(super) const CROSSES_ALL: u8 = CROSSES_SIDES | CROSSES_DEPTHS;

/// Frustum of a view: its window and its depth range, slightly widened.
#[derive(Clone, Copy, Debug)]
pub struct Frustum {
    sides: Planes,
    /// Near and far plane, twice.
    depths: Planes,
}

impl Frustum {
    /// The frustum for casters that reach at most a texel beyond their boxes.
    pub fn new(view: &GpuView) -> Self {
        // Particles smaller than a texel are enlarged to a radius of 0.7071 texel, and a quad reaches
        // 1.4143 times as far: one texel in all.
        Self::around(view, 1.0)
    }

    /// The frustum for casters that reach at most `enlarged` beyond their boxes \[texels\].
    pub fn around(view: &GpuView, enlarged: f64) -> Self {
        let (near, far) = (f64::from(view.near), f64::from(view.far));
        let scale = f64::from(view.scale);
        let Some(([right, up, back], shift)) = rigid_axes(view) else { return Self::everything() };
        // Written so that a NaN is refused.
        if !(far > near && scale > 0.0) {
            return Self::everything();
        }
        let half = view.size.as_dvec2() * 0.5;
        // The half texel between the window's border and its outermost texel centres is left for rounding.
        let texel = 1.0 / scale;
        // Rounding of the planes' own coefficients.
        let spare = |norm: f64| f64::from(ROUNDING) * norm * (shift.abs().element_sum() + texel);
        let (sides, first, last);
        if view.perspective > 0.0 {
            let side = |along: DVec3, along_shift: f64, edge: f64| {
                // An enlarged caster is a sphere of `enlarged` texels at its distance; where the window is
                // wide, it covers more of the slope.
                let edge = edge + enlarged * texel * (1.0 + edge * edge).sqrt();
                let norm = (1.0 + edge * edge).sqrt();
                let distance = -back * edge;
                let d = -shift.z * edge + spare(norm);
                [(distance - along, d - along_shift), (distance + along, d + along_shift)]
            };
            let x = side(right, shift.x, half.x * texel);
            let y = side(up, shift.y, half.y * texel);
            sides = [x[0], x[1], y[0], y[1]];
            let wide = enlarged * texel;
            first = if near > 0.0 { near / (1.0 + wide) } else { near };
            last = if wide < 0.5 { far / (1.0 - wide) } else { f64::INFINITY };
        } else {
            let side = |along: DVec3, along_shift: f64, half: f64| {
                let d = (half + enlarged) * texel + spare(1.0) + f64::from(ROUNDING) * half * texel;
                [(-along, d - along_shift), (along, d + along_shift)]
            };
            let (x, y) = (side(right, shift.x, half.x), side(up, shift.y, half.y));
            sides = [x[0], x[1], y[0], y[1]];
            (first, last) = (near - enlarged * texel, far + enlarged * texel);
        }
        let spare = spare(1.0) + f64::from(ROUNDING) * (near.abs() + far.abs());
        let depths = [(-back, -shift.z - first + spare), (back, last + shift.z + spare)];
        Self {
            sides: Planes::new(sides),
            depths: Planes::new([depths[0], depths[1], depths[0], depths[1]]),
        }
    }

    /// A frustum that contains everything, for views with invalid or skewed axes.
    fn everything() -> Self {
        let all = Planes::new([(DVec3::ZERO, 0.0); 4]);
        Self { sides: all, depths: all }
    }

    /// Left, right, bottom, top, near and far; inside is where `dot(p, xyz) + w >= 0`.
    pub fn planes(&self) -> [Vec4; 6] {
        let Self { sides, depths } = self;
        let plane = |of: &Planes, i: usize| Vec4::new(of.x[i], of.y[i], of.z[i], of.d[i]);
        [(sides, 0), (sides, 1), (sides, 2), (sides, 3), (depths, 0), (depths, 1)]
            .map(|(of, i)| plane(of, i))
    }

    /// Whether the frustum touches a box made by [`widened`].
    pub fn sees(&self, bounds: &Bounds) -> bool {
        self.cross(bounds.min, bounds.max, CROSSES_ALL).is_some()
    }

    /// `None` for a box outside; otherwise the flags of `planes` that it crosses, 0 if it is inside.
    #[inline]
    pub(super) fn cross(&self, min: Vec3, max: Vec3, planes: u8) -> Option<u8> {
        let center = (min + max) * 0.5;
        let half = max - center;
        let mut crossed = 0;
        for (bit, planes_of) in [(CROSSES_SIDES, &self.sides), (CROSSES_DEPTHS, &self.depths)] {
            if planes & bit != 0 {
                let (distance, reach) = planes_of.test(center, half);
                if (distance + reach).cmplt(Vec4::ZERO).any() {
                    return None;
                }
                // A NaN counts as crossing.
                if !(distance - reach).cmpge(Vec4::ZERO).all() {
                    crossed |= bit;
                }
            }
        }
        Some(crossed)
    }
}

/// Right, up and back axes of a view, and its coordinates of the world's origin. `None` if the axes are not
/// orthonormal.
pub(super) fn rigid_axes(view: &GpuView) -> Option<([DVec3; 3], DVec3)> {
    let axes = view.view_from_world.as_dmat4();
    let [right, up, back] = [0, 1, 2].map(|i| axes.row(i).truncate());
    let rigid = [right.dot(up), up.dot(back), back.dot(right)]
        .into_iter()
        .chain([right, up, back].map(|axis| axis.length_squared() - 1.0))
        .all(|skew| skew.abs() <= SKEW);
    rigid.then_some(([right, up, back], axes.w_axis.truncate()))
}

/// The box, enlarged for rounding, so that no touching box is lost. `None` if a coordinate is infinite, NaN
/// or too large: its contents are always visible.
pub fn widened(bounds: &Bounds) -> Option<Bounds> {
    /// Coordinate beyond which products leave the range of an `f32` \[m\].
    const FARTHEST: f32 = 1e15;
    let corners = [bounds.min, bounds.max].map(Vec3::abs);
    // Written so that a NaN is refused.
    if !corners.iter().all(|corner| corner.cmple(Vec3::splat(FARTHEST)).all()) {
        return None;
    }
    let largest = corners[0].max(corners[1]).max_element();
    let pad = Vec3::splat(largest * ROUNDING + 1e-30) + (bounds.max - bounds.min) * SKEWED;
    Some(Bounds { min: bounds.min - pad, max: bounds.max + pad })
}
