//! Light of hot media.
use glam::{Mat3, Vec3};

/// Planck's second radiation constant \[nm K\].
pub const RADIATION: f32 = 14_387_770.0;
/// First wavelength of the sum over the visible spectrum \[nm\].
pub const FIRST_WAVELENGTH: f32 = 380.0;
/// Distance of its wavelengths \[nm\].
pub const WAVELENGTH_STEP: f32 = 10.0;
/// Number of its wavelengths.
pub const WAVELENGTHS: u32 = 41;
/// Factor of the sum by which red is 1 at 1500 K.
pub const UNIT_RADIANCE: f32 = 423_638.56;
/// Least exponent of Planck's law for which exp(x) - 1 is representable.
pub const LEAST_POWER: f32 = 1e-3;
/// Largest such exponent.
pub const MOST_POWER: f32 = 80.0;

/// Linear sRGB from CIE XYZ (IEC 61966-2-1).
const RGB_FROM_XYZ: Mat3 = Mat3::from_cols(
    Vec3::new(3.2406, -0.9689, 0.0557),
    Vec3::new(-1.5372, 1.8758, -0.2040),
    Vec3::new(-0.4986, 0.0415, 1.0570),
);

/// Radiance of a black body (Planck 1901) seen by the CIE 1931 observer: linear sRGB, as a share of red at
/// 1500 K. Colours outside sRGB are clamped to it; 0 up to 0 K.
pub fn black_body(kelvin: f32) -> Vec3 {
    if kelvin.is_nan() || kelvin <= 0.0 {
        return Vec3::ZERO;
    }
    let of_wavelength = |i: u32| {
        let nm = FIRST_WAVELENGTH + WAVELENGTH_STEP * i as f32;
        let power = (RADIATION / (nm * kelvin)).clamp(LEAST_POWER, MOST_POWER);
        observer(nm) * ((600.0 / nm).powi(5) / (power.exp() - 1.0))
    };
    let seen: Vec3 = (0..WAVELENGTHS).map(of_wavelength).sum();
    (RGB_FROM_XYZ * seen * UNIT_RADIANCE).max(Vec3::ZERO)
}

/// Colour matching functions of CIE 1931 (Wyman, Sloan and Shirley 2013, section 2.2).
fn observer(nm: f32) -> Vec3 {
    let lobe = |height: f32, middle: f32, shorter: f32, longer: f32| {
        let aside = (nm - middle) / if nm < middle { shorter } else { longer };
        height * (-0.5 * aside * aside).exp()
    };
    Vec3::new(
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7)
            - lobe(0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DMat3, DVec3};

    /// The CIE's own table of its observer of 1931, from 380 nm in steps of 10 nm.
    const OBSERVER: [[f64; 3]; 38] = [
        [0.0014, 0.0000, 0.0065],
        [0.0042, 0.0001, 0.0201],
        [0.0143, 0.0004, 0.0679],
        [0.0435, 0.0012, 0.2074],
        [0.1344, 0.0040, 0.6456],
        [0.2839, 0.0116, 1.3856],
        [0.3483, 0.0230, 1.7471],
        [0.3362, 0.0380, 1.7721],
        [0.2908, 0.0600, 1.6692],
        [0.1954, 0.0910, 1.2876],
        [0.0956, 0.1390, 0.8130],
        [0.0320, 0.2080, 0.4652],
        [0.0049, 0.3230, 0.2720],
        [0.0093, 0.5030, 0.1582],
        [0.0633, 0.7100, 0.0782],
        [0.1655, 0.8620, 0.0422],
        [0.2904, 0.9540, 0.0203],
        [0.4334, 0.9950, 0.0087],
        [0.5945, 0.9950, 0.0039],
        [0.7621, 0.9520, 0.0021],
        [0.9163, 0.8700, 0.0017],
        [1.0263, 0.7570, 0.0011],
        [1.0622, 0.6310, 0.0008],
        [1.0026, 0.5030, 0.0003],
        [0.8544, 0.3810, 0.0002],
        [0.6424, 0.2650, 0.0000],
        [0.4479, 0.1750, 0.0000],
        [0.2835, 0.1070, 0.0000],
        [0.1649, 0.0610, 0.0000],
        [0.0874, 0.0320, 0.0000],
        [0.0468, 0.0170, 0.0000],
        [0.0227, 0.0082, 0.0000],
        [0.0114, 0.0041, 0.0000],
        [0.0058, 0.0021, 0.0000],
        [0.0029, 0.0010, 0.0000],
        [0.0014, 0.0005, 0.0000],
        [0.0007, 0.0003, 0.0000],
        [0.0003, 0.0001, 0.0000],
    ];

    /// Planck's law through the table in 64 bits, and from it linear sRGB by the primaries and white of
    /// Rec. 709.
    fn truth(kelvin: f64) -> DVec3 {
        let of_chromaticity = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let primaries = [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)];
        let [red, green, blue] = primaries.map(|(x, y)| of_chromaticity(x, y));
        let columns = DMat3::from_cols(red, green, blue);
        let shares = columns.inverse() * of_chromaticity(0.3127, 0.3290);
        let sum: DVec3 = (0..)
            .zip(OBSERVER)
            .map(|(i, observer)| {
                let um = 0.38 + 0.01 * f64::from(i);
                DVec3::from(observer) * um.powi(-5) / (14_387.77 / (um * kelvin)).exp_m1()
            })
            .sum();
        (columns * DMat3::from_diagonal(shares)).inverse() * sum
    }

    /// Error of the fit, as a share of the brightest channel: largest in its tail of deep red.
    const FITTED: f64 = 0.03;

    #[test]
    fn colours_are_those_of_the_observer() {
        let unit = truth(1500.0).x;
        for kelvin in [1000.0, 1500.0, 1850.0, 2700.0, 4000.0, 6500.0, 12_000.0, 60_000.0] {
            let expected = (truth(kelvin) / unit).max(DVec3::ZERO);
            let apart = (black_body(kelvin as f32).as_dvec3() - expected).abs();
            let share = apart.max_element() / expected.max_element();
            assert!(share < FITTED, "{kelvin} K: {share} of {expected}");
        }
        assert!((black_body(1500.0).x - 1.0).abs() < 1e-4, "{}", black_body(1500.0));
        let day = black_body(6504.0);
        assert!((day / day.y - 1.0).abs().max_element() < 0.08, "{day}");
    }

    #[test]
    fn any_number_has_a_colour() {
        for nothing in [0.0, -3.0, f32::NAN, f32::NEG_INFINITY] {
            assert_eq!(black_body(nothing), Vec3::ZERO);
        }
        assert!(black_body(20.0).max_element() < 1e-20);
        for hot in [1e-30, 1e7, f32::MAX, f32::INFINITY] {
            assert!(black_body(hot).is_finite(), "{hot}");
        }
    }
}
