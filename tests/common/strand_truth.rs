//! Strands in 64 bits, by definition: bisection finds the part of a ray inside.
use gobo::{
    glam::{DVec3, Vec4},
    model::Strand,
};

const HALVINGS: u32 = 80;
/// Distance to a surface below which a ray is on it [m].
const ON_SURFACE: f64 = 1e-6;
/// Distance and cosine below which a ray is in a plane [m].
const TIED: f64 = 1e-4;
/// Relative difference of a radius and the least one below which rounding decides which is taken.
const JUST_AS_WIDE: f64 = 1e-3;
/// Squared sine below which a ray counts as parallel to an axis.
const ALONG: f64 = 1e-8;

/// A ray's meeting with a capsule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Met {
    pub(crate) color: Vec4,
    pub(crate) way: Option<Way>,
    /// Whether the ray is in the plane of an end or on the surface, or the strand as wide as a texel, up to
    /// rounding.
    pub(crate) is_tied: bool,
}

/// A ray's path through a capsule.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Parameters of the ray where it enters and leaves.
    pub(crate) enters: f64,
    pub(crate) leaves: f64,
    /// Widened radii there [m].
    radii: [f64; 2],
    /// Greatest depth of the ray inside the cone [m]; negative outside.
    pub(crate) miss: f64,
    /// Length inside the capsule and in the whole cone [local diameters].
    inside: f64,
    whole: f64,
    thin: f64,
}

impl Way {
    /// Transmittance, if a diameter's is `passed`.
    pub(crate) fn passed(&self, passed: f64) -> f64 {
        let passed = passed.max(1e-9);
        if self.thin >= 1.0 {
            return passed.powf(self.inside);
        }
        (1.0 - self.thin * (1.0 - passed.powf(self.whole))).powf(self.inside / self.whole)
    }

    /// Share of its diameters in front of the ray's parameter `t`.
    pub(crate) fn share(&self, t: f64) -> f64 {
        let part = ((t - self.enters) / (self.leaves - self.enters)).clamp(0.0, 1.0);
        let growth = self.radii[1] / self.radii[0];
        // The integral of 1 / r over a linear r.
        if (growth - 1.0).abs() < 1e-6 {
            part
        } else {
            (1.0 + (growth - 1.0) * part).ln() / growth.ln()
        }
    }
}

struct Cone {
    first: DVec3,
    axis: DVec3,
    length: f64,
    radii: [f64; 2],
}

impl Cone {
    fn along(&self, point: DVec3) -> f64 {
        (point - self.first).dot(self.axis)
    }

    fn radius(&self, point: DVec3) -> f64 {
        let [a, b] = self.radii;
        a + (b - a) * self.along(point) / self.length
    }

    /// Depth inside the surface, across the axis; negative outside.
    fn depth(&self, point: DVec3) -> f64 {
        let off = point - self.first;
        self.radius(point) - (off - self.axis * off.dot(self.axis)).length()
    }
}

/// Hits of the ray `start + way t` on the capsules of a strand. `ends`: start and end of the ray; `least`:
/// radius at a point that the strand is widened to, linear along a capsule.
pub(crate) fn meet(
    strand: &Strand,
    start: DVec3,
    way: DVec3,
    ends: [f64; 2],
    least: impl Fn(DVec3) -> f64,
) -> Vec<Met> {
    let v = &strand.vertices;
    let at = |i: usize| v[i].position.as_dvec3();
    let axis = |i: usize| (at(i + 1) - at(i)).normalize();
    let steep = |i: usize| {
        f64::from(v[i + 1].radius - v[i].radius).abs() > 0.25 * at(i).distance(at(i + 1))
    };
    let plane = |i: usize, own: DVec3| {
        if i == 0 || i + 1 == v.len() {
            return own;
        }
        let (before, after) = (axis(i - 1), axis(i));
        let shared = before.dot(after) > 1e-3 && !steep(i - 1) && !steep(i);
        if shared { (before + after).normalize() } else { own }
    };
    // Widening of the whole ray, as at its point closest to the capsule's axis.
    let widened = |i: usize| {
        let (first, last, own) = (at(i), at(i + 1), axis(i));
        let flat = |v: DVec3| v - way * (v.dot(way) / way.length_squared());
        let (off, step) = (flat(first - start), flat(own));
        let turn = step.length_squared();
        // A ray along the axis takes the radius at its start.
        let begins = own.dot(start + way * ends[0] - first);
        let place = if turn < ALONG { begins } else { -off.dot(step) / turn };
        let place = place.clamp(0.0, first.distance(last));
        let share = place / first.distance(last);
        let true_radii = [v[i].radius.into(), v[i + 1].radius.into()];
        let least_radii = [least(first), least(last)];
        let at = |[a, b]: [f64; 2]| a + (b - a) * share;
        let [own, least] = [at(true_radii), at(least_radii)];
        let is_tied = (own - least).abs() < JUST_AS_WIDE * own;
        (if own < least { least_radii } else { true_radii }, is_tied)
    };
    let capsule = |i: usize| {
        let (first, last, own) = (at(i), at(i + 1), axis(i));
        let length = first.distance(last);
        let (radii, as_wide) = widened(i);
        let cone = Cone { first, axis: own, length, radii };
        // Planes between capsules lean by at most 45 degrees, so no capsule reaches farther.
        let reach = 0.5 * length + 3.0 * cone.radii[0].max(cone.radii[1]);
        let off = (first + last) * 0.5 - start;
        let color = (v[i].color + v[i + 1].color) * 0.5;
        if off.cross(way).length() > reach * way.length() {
            return Met { color, way: None, is_tied: false };
        }
        let true_cone = Cone { radii: [v[i].radius.into(), v[i + 1].radius.into()], first, ..cone };
        let (mut clip, mut is_tied) = (ends, false);
        for (normal, point, sign) in [(plane(i, own), first, 1.0), (plane(i + 1, own), last, -1.0)]
        {
            let (inside, change) = ((start - point).dot(normal) * sign, way.dot(normal) * sign);
            is_tied |= inside.abs() < TIED && change.abs() < TIED * way.length();
            let t = -inside / change;
            if change > 0.0 {
                clip[0] = clip[0].max(t);
            } else if change < 0.0 {
                clip[1] = clip[1].min(t);
            } else if inside < 0.0 {
                clip = [f64::INFINITY, f64::NEG_INFINITY];
            }
        }
        match through(&cone, &true_cone, start, way, clip) {
            Ok(way) => Met { color, way, is_tied: is_tied || (as_wide && way.is_some()) },
            Err(OnSurface) => Met { color, way: None, is_tied: true },
        }
    };
    (0..v.len() - 1).map(capsule).collect()
}

struct OnSurface;

fn through(
    cone: &Cone,
    own: &Cone,
    start: DVec3,
    way: DVec3,
    clip: [f64; 2],
) -> Result<Option<Way>, OnSurface> {
    let point = |t: f64| start + way * t;
    let depth = |t: f64| cone.depth(point(t));
    // The depth is concave along the ray; far outside the capsule nothing is searched.
    let near = (cone.first - start).dot(way) / way.length_squared();
    let far = 1e4 * cone.length + 100.0 * (cone.radii[0] + cone.radii[1]);
    let [mut low, mut high] = [near - far, near + far];
    for _ in 0..2 * HALVINGS {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if depth(a) < depth(b) {
            low = a;
        } else {
            high = b;
        }
    }
    let deepest = 0.5 * (low + high);
    let miss = depth(deepest);
    if clip[0] < clip[1] && depth(deepest.clamp(clip[0], clip[1])).abs() < ON_SURFACE {
        return Err(OnSurface);
    }
    if miss < ON_SURFACE {
        return Ok(None);
    }
    let crossing = |outside: f64| {
        if depth(outside) > 0.0 {
            return outside;
        }
        let (mut inside, mut outside) = (deepest, outside);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if depth(middle) > 0.0 {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    };
    let whole = [crossing(near - far), crossing(near + far)];
    let [enters, leaves] = [whole[0].max(clip[0]), whole[1].min(clip[1])];
    let radii = [enters, leaves].map(|t| cone.radius(point(t)));
    // Through the very tip a ray's length in diameters is infinite.
    if enters < leaves && radii[0].min(radii[1]) < ON_SURFACE {
        return Err(OnSurface);
    }
    // The integral of 1 / (2 r) over a linear r.
    let diameters = |from: f64, to: f64| {
        let [a, b] = [from, to].map(|t| cone.radius(point(t)));
        let length = (to - from) * way.length();
        let is_even = (b - a).abs() < 1e-6 * (a + b);
        if is_even { length / (a + b) } else { 0.5 * length * (b / a).ln() / (b - a) }
    };
    let middle = point(0.5 * (enters + leaves));
    let thin = (own.radius(middle) / cone.radius(middle)).clamp(0.0, 1.0);
    let inside = diameters(enters, leaves);
    // A ray within the cone's own angle never leaves it.
    let cosine = way.normalize().dot(cone.axis);
    let grows = (cone.radii[1] - cone.radii[0]) / cone.length * cosine;
    let turn = 1.0 - cosine * cosine;
    let is_endless = turn <= grows * grows || turn < ALONG;
    let whole = if is_endless { f64::INFINITY } else { diameters(whole[0], whole[1]) };
    Ok((enters < leaves).then_some(Way { enters, leaves, radii, miss, inside, whole, thin }))
}
