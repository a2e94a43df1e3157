//! Methods for comparison with curves: every hit kept, and the representations of others.
use gobo::glam::Vec3;
use std::f64::consts::TAU;

/// One hit: light depth and transmittance.
pub(crate) type Hit = (f32, Vec3);

/// Exact light: the product of all hits in front of `z`.
pub(crate) fn exact(hits: &[Hit], z: f32) -> Vec3 {
    hits.iter().filter(|(depth, _)| *depth < z).map(|(_, light)| *light).product()
}

/// Optical depth, per channel; black is 7.
pub(crate) fn optical_depth(light: Vec3) -> [f64; 3] {
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
