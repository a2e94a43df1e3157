//! Light of what is hot.
use glam::Vec3;

/// Wavelengths of red, green and blue [um]: the dominant ones of the primaries of sRGB.
pub const WAVELENGTHS: [f32; 3] = [0.6114, 0.5491, 0.4643];
/// Planck's second radiation constant [um K].
pub const RADIATION: f32 = 14_387.77;
/// Temperature at which red is 1 [K].
pub const UNIT_TEMPERATURE: f32 = 1500.0;
/// Exponent up to which numbers hold its power.
const MOST: f32 = 80.0;

/// Radiance of a black body (Planck 1901) at the wavelengths of red, green and blue, as a share of that of red at
/// 1500 K; 0 up to 0 K.
pub fn black_body(kelvin: f32) -> Vec3 {
    if kelvin.is_nan() || kelvin <= 0.0 {
        return Vec3::ZERO;
    }
    let unit = (RADIATION / (WAVELENGTHS[0] * UNIT_TEMPERATURE)).exp() - 1.0;
    Vec3::from_array(WAVELENGTHS.map(|wavelength| {
        let power = (RADIATION / (wavelength * kelvin)).min(MOST);
        (WAVELENGTHS[0] / wavelength).powi(5) * unit / (power.exp() - 1.0)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of Planck's law in 64 bits; a candle is orange, the sun white.
    #[test]
    fn colours_of_temperatures() {
        let truth = |kelvin: f64, um: f64| um.powi(-5) / ((14_387.77 / (um * kelvin)).exp() - 1.0);
        let unit = truth(1500.0, f64::from(WAVELENGTHS[0]));
        for kelvin in [700.0, 1000.0, 1500.0, 1850.0, 3000.0, 6500.0, 60_000.0] {
            let radiances = black_body(kelvin as f32).as_dvec3().to_array();
            for (radiance, um) in radiances.into_iter().zip(WAVELENGTHS) {
                let expected = truth(kelvin, f64::from(um)) / unit;
                assert!(
                    (radiance / expected - 1.0).abs() < 1e-4,
                    "{kelvin} K: {radiance}, {expected}"
                );
            }
        }
        let [candle, sun] = [1850.0, 6500.0].map(black_body);
        assert!(candle.y < 0.6 * candle.x && candle.z < 0.2 * candle.x, "{candle}");
        assert!((sun / sun.x - 1.0).abs().max_element() < 0.25, "{sun}");
        assert_eq!(black_body(0.0), Vec3::ZERO);
        assert!(black_body(20.0).max_element() < 1e-20 && black_body(f32::NAN) == Vec3::ZERO);
    }
}
