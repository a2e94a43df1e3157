//! CPU reference of `wgsl/project/project_gaussians.wgsl` and `wgsl/hit/gaussian.wgsl`: Gaussians.
//!
//! The plane form of Hahlbohm et al. 2024 (HTGS, section 4), `q^2 = |w2 n1 - w1 n2|^2 / |n1 x n2|^2`,
//! relative to the centre's position in the map. There the numerator is the quadratic form of the projected
//! covariance, whitened once per view; the denominator is the square of a linear function plus a share of the
//! numerator ([`GaussianSetup`]). No term is a difference of large numbers, and nothing is divided by a
//! deviation.
use super::{
    outline::{Ellipse, outline_of, outlined_tiles},
    project::{MIN_COSINE, ProjectParams, Projected, TexelBox, depth_key, tangents, tile_rect},
};
use glam::{Vec2, Vec3};
use gobo::{
    model::{Transfer, reach_squared},
    records::{
        CasterRecord, Footprint, GAUSSIAN_MARK, GaussianAxes, GaussianSetup, GpuMaterial, GpuView,
        MEDIUM_BIT, NEUTRAL_BIT, OPACITY_SCALE, TileRect,
    },
};

mod hit;

pub use hit::*;

/// Square of a projected deviation below which the conic is enlarged \[texels²\].
pub const MIN_SQUARE: f32 = 0.5;
/// Squared distance from the centre up to which a deviation is measured in the map \[standard deviations\]:
/// close to the eye a Gaussian may span many texels although its middle is thinner than one.
pub const MEASURED_AT: f32 = 4.0;
/// Least squared distance of the eye from the centre of a Gaussian beside the view \[standard deviations\].
pub const NEAREST_EYE: f32 = 1e-12;
/// Squared sine below which a step to the right is along the direction to the centre.
pub const ALONG: f32 = 1e-10;
/// Ratio of the squared projected deviations below which the smaller one has no direction in space.
pub const FLAT: f32 = 1e-12;
/// Least deviation of a Gaussian beside the view, a share of its longest.
pub const THINNEST: f32 = 1e-5;
/// Bounds of a Gaussian that reaches the eye's plane \[texels\].
pub const ENDLESS: f32 = 1e6;
/// Deviations around the closest approach in which a medium absorbs.
pub const MEDIUM_REACH: f32 = 4.0;
/// Square root of 2 pi: the integral of `exp(-x^2 / 2)`.
pub const ROOT_TAU: f32 = 2.506_628_3;

/// A Gaussian's position in a view's map, before its opacity.
struct PlacedGaussian {
    /// Footprint's centre, and depth.
    center: Vec2,
    depth: f32,
    is_beside: bool,
    setup: GaussianSetup,
    /// Ratio of the area before and after enlargement.
    thin: f32,
    bounds: TexelBox,
    /// `None` if unknown.
    ellipse: Option<Ellipse>,
}

/// Components to the right, down and along the axis.
fn to_map(v: Vec3) -> Vec3 {
    v * Vec3::new(1.0, -1.0, -1.0)
}

/// Projects one Gaussian to view number `view_index` of its batch. `number`: index of its setup.
#[allow(clippy::too_many_arguments, reason = "the records of one caster, as the kernel reads them")]
pub fn project_gaussian(
    view: &GpuView,
    view_index: u32,
    caster: &CasterRecord,
    axes: &GaussianAxes,
    caster_id: u32,
    number: u32,
    material: &GpuMaterial,
    params: ProjectParams,
) -> (Projected, GaussianSetup) {
    let nothing = (Projected::INVISIBLE, GaussianSetup::default());
    let center = to_map(view.view_from_world.transform_point3(caster.center));
    let columns = axes.columns();
    let axes_in_map = [columns.x_axis, columns.y_axis, columns.z_axis]
        .map(|axis| to_map(view.view_from_world.transform_vector3(axis)));
    let color = caster.color(material.transfer) * material.tint;
    let is_medium = caster.material_rotation & MEDIUM_BIT != 0;
    let longest = axes.sigma.max_element();
    let amplitude = color.w * if is_medium { OPACITY_SCALE * ROOT_TAU } else { 1.0 };
    let opacity = amplitude * if is_medium { longest } else { 1.0 };
    let squared = reach_squared(opacity);
    let is_beside = view.perspective > 0.0 && center.z <= MIN_COSINE * center.length();
    let placed = if is_beside {
        beside(view, center, axes_in_map, axes.sigma, squared)
    } else {
        within(view, center, axes_in_map, squared)
    };
    // A medium absorbs in front of its closest approach and behind it.
    let reach = squared.sqrt() + if is_medium { MEDIUM_REACH } else { 0.0 };
    let depth_reach = reach * row(axes_in_map, 2).length();
    let range = view.far - view.near;
    let nearest = (center.z - depth_reach - view.near) / range;
    let farthest = (center.z + depth_reach - view.near) / range;
    let unseen = material.transfer == Transfer::None as u32 && !params.include_non_casters;
    // Written so that a NaN is invisible.
    if unseen || !(amplitude > 0.0 && farthest >= 0.0 && nearest <= 1.0) {
        return nothing;
    }
    let front = if params.by_distance && view.perspective > 0.0 {
        let away = center.length();
        let toward = center / away.max(f32::MIN_POSITIVE);
        let along = Vec3::from_array(axes_in_map.map(|axis| axis.dot(toward))).length();
        view.distance_key((away - reach * along).max(0.0))
    } else {
        nearest
    };
    let PlacedGaussian { center: at, depth, is_beside, mut setup, thin, bounds, ellipse } = placed;
    let radius = squared.sqrt() * if is_beside { -1.0 } else { 1.0 };
    let Some(rect) = tile_rect(view, view_index, bounds, at, f32::INFINITY, false) else {
        return nothing;
    };
    let outline = ellipse.and_then(|ellipse| outline_of(&ellipse, *rect.y().start()));
    let rect = outline.map_or(rect, |outline| outlined_tiles(&outline, rect));
    if rect == TileRect::EMPTY {
        return nothing;
    }
    setup.outline = outline.unwrap_or_default();
    let is_black = caster.material_rotation & NEUTRAL_BIT != 0 && !params.include_non_casters;
    let rgb = if is_black { Vec3::ZERO } else { color.truncate().min(Vec3::ONE) };
    setup.set_color(rgb, material.transfer, thin);
    let amplitude = amplitude * if is_medium { 1.0 } else { thin };
    let footprint = Footprint {
        center: at,
        radius,
        depth,
        red_green: number,
        blue_slope: amplitude.to_bits(),
        thin: GAUSSIAN_MARK,
        caster: caster_id,
    };
    (Projected { footprint, key: depth_key(front), rect }, setup)
}

/// One component of three vectors.
fn row(vectors: [Vec3; 3], component: usize) -> Vec3 {
    Vec3::from_array(vectors.map(|vector| vector[component]))
}

/// A Gaussian whose centre has a position in the map. `axes`: its deviations to the right, down and along the
/// axis \[m\]; `squared`: distance at which it ends.
fn within(view: &GpuView, center: Vec3, axes: [Vec3; 3], squared: f32) -> PlacedGaussian {
    let half = view.size * 0.5;
    let range = view.far - view.near;
    let [x, y, z] = [0, 1, 2].map(|i| row(axes, i));
    let is_perspective = view.perspective > 0.0;
    let (at, p, q, along);
    if is_perspective {
        let slope = center.truncate() / center.z;
        let per_metre = view.scale / center.z;
        at = slope * view.scale + half;
        (p, q) = ((x - z * slope.x) * per_metre, (y - z * slope.y) * per_metre);
        along = z / center.z;
    } else {
        at = center.truncate() * view.scale + half;
        (p, q) = (x * view.scale, y * view.scale);
        along = z / range;
    }
    let conic = Conic::new(p, q, along, is_perspective);
    let ellipse = conic.ellipse(at, squared, is_perspective);
    let endless = || TexelBox { min: Vec2::splat(-ENDLESS), max: Vec2::splat(ENDLESS) };
    PlacedGaussian {
        center: at,
        depth: (center.z - view.near) / range,
        is_beside: false,
        setup: conic.setup(),
        thin: conic.thin,
        bounds: ellipse.as_ref().map_or_else(endless, Ellipse::bounds),
        ellipse,
    }
}

/// A Gaussian's projected covariance in its principal axes.
struct Conic {
    /// Principal axis of the larger deviation, unit; the other axis is to its left.
    major: Vec2,
    /// Enlarged squared deviations [texels²].
    squares: Vec2,
    /// Change of the distance along the axis per deviation.
    tilt: Vec2,
    spread: f32,
    thin: f32,
}

impl Conic {
    /// `p`, `q`: deviations to the right and down, in the Gaussian's own space \[texels\]; `along`: along the
    /// axis, as a share of the distance.
    fn new(p: Vec3, q: Vec3, along: Vec3, is_perspective: bool) -> Self {
        let (xx, xy, yy) = (p.dot(p), p.dot(q), q.dot(q));
        let apart = 0.5 * (xx - yy);
        let radius = (apart * apart + xy * xy).sqrt();
        let large = (0.5 * (xx + yy) + radius).max(f32::MIN_POSITIVE);
        let small = p.cross(q).length_squared() / large;
        let axis = if apart >= 0.0 {
            Vec2::new(apart + radius, xy)
        } else {
            Vec2::new(xy, radius - apart)
        };
        let length = axis.length();
        let major = if length > 0.0 { axis / length } else { Vec2::X };
        let w1 = (p * major.x + q * major.y) / large.sqrt();
        let across = q * major.x - p * major.y;
        let across = across - w1 * w1.dot(across);
        let tilt1 = -along.dot(w1);
        let (tilt2, spread) = if small > FLAT * large {
            let w2 = across / across.length();
            let ray = along.dot(w1.cross(w2));
            (-along.dot(w2), ray * ray)
        } else {
            (0.0, (along.dot(along) - tilt1 * tilt1).max(0.0))
        };
        let tilt = Vec2::new(tilt1, tilt2);
        // Along the principal axes, the map shows the deviations times the root of `rest / open^2`.
        let measured = if is_perspective { MEASURED_AT } else { 0.0 };
        let open = (1.0 - (tilt * tilt + spread) * measured).max(Vec2::ZERO);
        let rest = (tilt * tilt * measured + open).max(Vec2::splat(f32::MIN_POSITIVE));
        let least = (MIN_SQUARE * open * open / rest).max(Vec2::splat(FLAT * large));
        let squares = Vec2::new(large, small).max(least);
        let thin = (large / squares.x * (small / squares.y)).sqrt();
        Self { major, squares, tilt, spread, thin }
    }

    /// The setup, with the whitening in triangular form.
    fn setup(&self) -> GaussianSetup {
        let Self { major, squares, tilt, spread, .. } = *self;
        let row1 = major / squares.x.sqrt();
        let row2 = Vec2::new(-major.y, major.x) / squares.y.sqrt();
        let a = Vec2::new(row1.x, row2.x).length();
        let turn = Vec2::new(row1.x, row2.x) / a;
        GaussianSetup {
            whitening: Vec3::new(
                a,
                turn.x * row1.y + turn.y * row2.y,
                turn.x * row2.y - turn.y * row1.y,
            ),
            spread,
            tilt: Vec2::new(turn.x * tilt.x + turn.y * tilt.y, turn.x * tilt.y - turn.y * tilt.x),
            ..GaussianSetup::default()
        }
    }

    /// The texels with `q^2 <= squared`, by the dual conic; `None` if the Gaussian reaches the eye's plane.
    fn ellipse(&self, center: Vec2, squared: f32, is_perspective: bool) -> Option<Ellipse> {
        let Self { major, squares, tilt, spread, .. } = *self;
        let minor = Vec2::new(-major.y, major.x);
        let square = major * major * squares.x + minor * minor * squares.y;
        let (mut open, mut rest, mut lean) = (1.0, 1.0, Vec2::ZERO);
        if is_perspective {
            rest = 1.0 - squared * spread;
            open = 1.0 - squared * spread - squared * tilt.length_squared();
            let across = tilt * squares.map(f32::sqrt);
            lean = (major * across.x + minor * across.y) * squared;
        }
        if open.is_nan() || open <= 0.0 {
            return None;
        }
        let half = (lean * lean + square * (squared * open)).map(f32::sqrt) / open;
        // Its shape matrix [W^2, L H; L H, H^2] of half width, lean and half height.
        let aslant = lean.x * lean.y + squared * open * major.x * major.y * (squares.x - squares.y);
        let area = (squares.x * squares.y * rest / (open * open * open)).sqrt();
        Some(Ellipse {
            middle: center + lean / open,
            half,
            lean: aslant / (open * open * half.y),
            width: squared * area / half.y,
            open,
        })
    }
}

/// A Gaussian without a position in the map: relative to the map's centre, `u` has an offset, the footprint's
/// centre, and `e = depth + tilt . delta` [1/m].
fn beside(
    view: &GpuView,
    center: Vec3,
    axes: [Vec3; 3],
    sigma: Vec3,
    squared: f32,
) -> PlacedGaussian {
    let half = view.size * 0.5;
    let sphere = sigma.max_element() * squared.sqrt();
    let x = tangents(center.x, center.z, sphere);
    let y = tangents(center.y, center.z, sphere);
    let sigma = sigma.max(Vec3::splat(sigma.max_element() * THINNEST));
    let axes = axes.map(Vec3::normalize_or_zero);
    let whitened = |v: Vec3| Vec3::from_array(axes.map(|axis| axis.dot(v))) / sigma;
    let eye = whitened(center);
    let away = eye.length_squared().max(NEAREST_EYE);
    let toward = eye.normalize_or(Vec3::X);
    let (right, down, along) =
        (whitened(Vec3::X) / view.scale, whitened(Vec3::Y) / view.scale, whitened(Vec3::Z));
    // Two directions perpendicular to the one from the eye to the centre; the second is also perpendicular to
    // a step to the right.
    let step = right - toward * toward.dot(right);
    let first = if step.length_squared() > ALONG * right.length_squared() {
        // Removes the rounding error along the direction to the centre.
        let step = step.normalize();
        (step - toward * toward.dot(step)).normalize()
    } else {
        toward.any_orthonormal_vector()
    };
    let second = toward.cross(first);
    let ahead = toward / away.sqrt();
    let setup = GaussianSetup {
        whitening: Vec3::new(first.dot(right), first.dot(down), second.dot(down)),
        spread: 1.0 / away,
        tilt: Vec2::new(ahead.dot(right), ahead.dot(down)),
        ..GaussianSetup::default()
    };
    PlacedGaussian {
        center: Vec2::new(first.dot(along), second.dot(along)),
        depth: ahead.dot(along),
        is_beside: true,
        setup,
        thin: 1.0,
        bounds: TexelBox {
            min: Vec2::new(x.x, y.x) * view.scale + half,
            max: Vec2::new(x.y, y.y) * view.scale + half,
        },
        ellipse: None,
    }
}
