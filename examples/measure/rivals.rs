//! Methods that curves are compared with: every hit kept, and the representations of others.
use gobo::glam::Vec3;
use std::f64::consts::TAU;

/// One hit: light depth and transmittance.
pub(crate) type Hit = (f32, Vec3);

/// Exact light: the product of all hits in front of `z`.
pub(crate) fn exact(hits: &[Hit], z: f32) -> Vec3 {
    hits.iter().filter(|(depth, _)| *depth < z).map(|(_, light)| *light).product()
}

/// Optical depth, per channel; black is 7.
fn optical_depth(light: Vec3) -> [f64; 3] {
    light.to_array().map(|v| -f64::from(v.max((-7.0_f32).exp())).ln())
}

/// Nearest-depth mode: the whole product behind the nearest hit.
pub(crate) fn nearest(hits: &[Hit], z: f32) -> Vec3 {
    if hits.iter().any(|(depth, _)| *depth < z) { exact(hits, 2.0) } else { Vec3::ONE }
}

/// Fourier opacity map with 15 coefficients a channel (Jansen and Bavoil 2010, section 3).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fourier {
    /// Coefficients of cosines and sines, per channel.
    waves: [[(f64, f64); Self::WAVES]; 3],
}

impl Fourier {
    /// Number of waves, with the constant one; 7 pairs and the constant are 15 coefficients.
    const WAVES: usize = 8;

    pub(crate) fn new(hits: &[Hit]) -> Self {
        let mut waves = [[(0.0, 0.0); Self::WAVES]; 3];
        for &(depth, light) in hits {
            for (waves, tau) in waves.iter_mut().zip(optical_depth(light)) {
                for (k, (a, b)) in (0..).zip(waves) {
                    let (sin, cos) = (TAU * f64::from(k) * f64::from(depth)).sin_cos();
                    *a += 2.0 * tau * cos;
                    *b += 2.0 * tau * sin;
                }
            }
        }
        Self { waves }
    }

    pub(crate) fn light_at(&self, z: f32) -> Vec3 {
        let z = f64::from(z);
        let light = self.waves.map(|waves| {
            let mut tau = waves[0].0 * 0.5 * z;
            for (k, (a, b)) in (0..).zip(waves).skip(1) {
                let w = TAU * f64::from(k);
                tau += a / w * (w * z).sin() + b / w * (1.0 - (w * z).cos());
            }
            (-tau.max(0.0)).exp() as f32
        });
        Vec3::from_array(light)
    }
}

/// Four power moments of the optical depth, per channel (Peters et al. 2017; the solver is
/// Münstermann et al. 2018, listing 1).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    /// Total, and moments 1 to 4 of depths in -1..1, per channel.
    sums: [[f64; 5]; 3],
}

impl Moments {
    /// Bias of 32-bit moments towards those of a uniform distribution.
    const BIAS: f64 = 5e-7;
    const UNIFORM: [f64; 4] = [0.0, 0.375, 0.0, 0.375];
    /// Weight between the lower bound of the absorbed light and the upper one.
    const OVERESTIMATION: f64 = 0.25;

    pub(crate) fn new(hits: &[Hit]) -> Self {
        let mut sums = [[0.0; 5]; 3];
        for &(depth, light) in hits {
            let z = 2.0 * f64::from(depth) - 1.0;
            for (sums, tau) in sums.iter_mut().zip(optical_depth(light)) {
                for (power, sum) in (0..).zip(sums) {
                    *sum += tau * z.powi(power);
                }
            }
        }
        Self { sums }
    }

    pub(crate) fn light_at(&self, z: f32) -> Vec3 {
        let z = 2.0 * f64::from(z) - 1.0;
        Vec3::from_array(self.sums.map(|sums| {
            let total = sums[0];
            if total < 1e-9 {
                1.0
            } else {
                (-total * absorbed_share(&sums, z)).exp().min(1.0) as f32
            }
        }))
    }
}

/// Estimate of the share of the optical depth that lies in front of `z`.
fn absorbed_share(sums: &[f64; 5], z: f64) -> f64 {
    let moment = |i: usize| {
        let own = sums[i + 1] / sums[0];
        own + (Moments::UNIFORM[i] - own) * Moments::BIAS
    };
    let b = [moment(0), moment(1), moment(2), moment(3)];
    // Cholesky factors of the Hankel matrix, then its system for (1, z, z^2).
    let l21_d11 = b[2] - b[0] * b[1];
    let d11 = b[1] - b[0] * b[0];
    let l21 = l21_d11 / d11;
    let d22 = b[3] - b[1] * b[1] - l21_d11 * l21;
    let mut c = [1.0, z - b[0], z * z];
    c[2] -= b[1] + l21 * c[1];
    c[1] /= d11;
    c[2] /= d22;
    c[1] -= l21 * c[2];
    c[0] -= c[1] * b[0] + c[2] * b[1];
    // The other two depths at which the bound's distribution is not zero.
    let (p, q) = (c[1] / c[2], c[0] / c[2]);
    let root = (p * p * 0.25 - q).max(0.0).sqrt();
    let at = [z, -0.5 * p - root, -0.5 * p + root];
    let step = |depth: f64| if depth < z { 1.0 } else { 0.0 };
    let f = [Moments::OVERESTIMATION, step(at[1]), step(at[2])];
    // Newton's interpolation of f, integrated by the moments.
    let f01 = (f[1] - f[0]) / (at[1] - at[0]);
    let f12 = (f[2] - f[1]) / (at[2] - at[1]);
    let f012 = (f12 - f01) / (at[2] - at[0]);
    let linear = f01 - f012 * at[1];
    let constant = f[0] - linear * at[0];
    let share = constant + (linear - f012 * at[0]) * b[0] + f012 * b[1];
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 1.0 }
}
