//! Gaussians in 64 bits, from their definition: in their own space, ray by ray; media by quadrature.
use gobo::{
    glam::{DMat3, DVec3},
    model::{Gaussian, GaussianOpacity, Material},
};

/// Panels of the quadrature, and how far it goes [standard deviations].
const PANELS: u32 = 64;
const FARTHEST: f64 = 12.0;

/// A ray's meeting with a Gaussian: `start + way t`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    pub(crate) alpha: f64,
    /// Where it is met.
    pub(crate) t: f64,
    /// Standard deviation along the ray, in `t`; 0 for a splat.
    pub(crate) deviation: f64,
}

/// `ends`: where the ray begins and ends.
pub(crate) fn meet(
    gaussian: &Gaussian,
    material: &Material,
    start: DVec3,
    way: DVec3,
    ends: [f64; 2],
) -> Meeting {
    let rotation = DMat3::from_quat(gaussian.rotation.as_dquat().normalize());
    let own = |v: DVec3| rotation.transpose() * v / gaussian.sigma.as_dvec3();
    let (from, along) = (own(start - gaussian.center.as_dvec3()), own(way));
    let share = |t: f64| (-0.5 * (from + along * t).length_squared()).exp();
    let t = -from.dot(along) / along.length_squared();
    let opacity = f64::from(gaussian.opacity * material.tint.w);
    match material.gaussian {
        GaussianOpacity::Medium { density } => {
            let deviation = 1.0 / along.length();
            let (low, high) = (t - FARTHEST * deviation, t + FARTHEST * deviation);
            if share(t) < (-0.5 * FARTHEST * FARTHEST).exp() {
                return Meeting { alpha: 0.0, t, deviation };
            }
            let (low, high) = (low.max(ends[0]), high.min(ends[1]));
            let tau = f64::from(density) * opacity * way.length() * simpson(low, high, share);
            Meeting { alpha: 1.0 - (-tau).exp(), t, deviation }
        }
        _ => Meeting { alpha: opacity * share(t), t, deviation: 0.0 },
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
