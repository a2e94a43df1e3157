//! Gaussians in 64 bits, by definition: in their own space, ray by ray; media by quadrature.
use gobo::{
    glam::{DMat3, DVec2, DVec3},
    model::{Gaussian, GaussianOpacity, Material},
};

/// Panels of the quadrature, and its range [standard deviations].
const PANELS: u32 = 64;
const FARTHEST: f64 = 12.0;

/// A ray's meeting with a Gaussian: `start + way t`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Alpha before it is reduced.
    pub(crate) alpha: f64,
    /// Ratio of its area to its widened area.
    pub(crate) thin: f64,
    /// Parameter of the hit.
    pub(crate) t: f64,
    /// Standard deviation along the ray, in `t`; 0 for a splat.
    pub(crate) deviation: f64,
}

/// A Gaussian in a view.
pub(crate) struct Seen {
    center: DVec3,
    /// Its own space from world space.
    own: DMat3,
    /// Ratio of the areas.
    thin: f64,
}

impl Seen {
    /// The Gaussian, not widened.
    pub(crate) fn whole(gaussian: &Gaussian) -> Self {
        let rotation = DMat3::from_quat(gaussian.rotation.as_dquat().normalize());
        let own = DMat3::from_diagonal(gaussian.sigma.as_dvec3().recip()) * rotation.transpose();
        Self { center: gaussian.center.as_dvec3(), own, thin: 1.0 }
    }

    /// Widened across the ray to its centre until no principal deviation of its projection is below `least`,
    /// and reduced by the ratio of the areas. `to_map`: world to a position in texels and a distance along
    /// the axis; linear about the centre, where the projection is taken. `line`: the ray through a position
    /// in texels from the centre. The width along a direction is measured: a quarter of the range within two
    /// deviations.
    pub(crate) fn widened(
        gaussian: &Gaussian,
        to_map: DMat3,
        least: f64,
        line: impl Fn(DVec2) -> [DVec3; 2],
    ) -> Self {
        let Self { center, own, .. } = Self::whole(gaussian);
        let axes = to_map * own.inverse();
        let [x, y] = [0, 1].map(|i| axes.row(i));
        // Principal directions in the map, by the angle of its covariance.
        let angle = 0.5 * (2.0 * x.dot(y)).atan2(x.dot(x) - y.dot(y));
        let (sin, cos) = angle.sin_cos();
        let turned = [x * cos + y * sin, y * cos - x * sin];
        let distance = |place: DVec2| {
            let [start, way] = line(place);
            let (from, along) = (own * (start - center), own * way);
            from.cross(along).length() / along.length()
        };
        // The first position two deviations off: growing steps, then halvings.
        let reach = |direction: DVec2| {
            let mut steps = (0..4000).map(|i| 1e-9 * 1.01_f64.powi(i));
            let Some(mut far) = steps.find(|step| distance(direction * *step) >= 2.0) else {
                return f64::INFINITY;
            };
            let mut near = far / 1.01;
            for _ in 0..40 {
                let middle = 0.5 * (near + far);
                *if distance(direction * middle) >= 2.0 { &mut far } else { &mut near } = middle;
            }
            far
        };
        let mut grown = turned;
        for (axis, direction) in grown.iter_mut().zip([DVec2::new(cos, sin), DVec2::new(-sin, cos)])
        {
            let measured = 0.25 * (reach(direction) + reach(-direction));
            *axis *= (least / measured).max(1.0);
        }
        let [a, b] = grown;
        let rows = [a * cos - b * sin, a * sin + b * cos, axes.row(2)];
        let thin = turned[0].length() * turned[1].length() / (a.length() * b.length());
        let own = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose().inverse() * to_map;
        Self { center, own, thin }
    }
}

/// `ends`: start and end of the ray.
pub(crate) fn meet(
    seen: &Seen,
    gaussian: &Gaussian,
    material: &Material,
    start: DVec3,
    way: DVec3,
    ends: [f64; 2],
) -> Meeting {
    let (from, along) = (seen.own * (start - seen.center), seen.own * way);
    let share = |t: f64| (-0.5 * (from + along * t).length_squared()).exp();
    let t = -from.dot(along) / along.length_squared();
    let opacity = f64::from(gaussian.opacity * material.tint.w);
    let thin = seen.thin;
    match material.gaussian {
        GaussianOpacity::Medium { density } => {
            let deviation = 1.0 / along.length();
            let (low, high) = (t - FARTHEST * deviation, t + FARTHEST * deviation);
            if share(t) < (-0.5 * FARTHEST * FARTHEST).exp() {
                return Meeting { alpha: 0.0, thin, t, deviation };
            }
            let (low, high) = (low.max(ends[0]), high.min(ends[1]));
            let tau = f64::from(density) * opacity * way.length() * simpson(low, high, share);
            Meeting { alpha: 1.0 - (-tau).exp(), thin, t, deviation }
        }
        _ => Meeting { alpha: opacity * share(t), thin, t, deviation: 0.0 },
    }
}

fn simpson(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    if high <= low {
        return 0.0;
    }
    let step = (high - low) / f64::from(2 * PANELS);
    let weight = |i: u32| match i {
        _ if i == 0 || i == 2 * PANELS => 1.0,
        _ if i % 2 == 1 => 4.0,
        _ => 2.0,
    };
    (0..=2 * PANELS).map(|i| weight(i) * f(low + step * f64::from(i))).sum::<f64>() * step / 3.0
}
