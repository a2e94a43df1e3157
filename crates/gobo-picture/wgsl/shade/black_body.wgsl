// Light of hot media. CPU reference: src/model/black_body.rs.

const RADIATION: f32 = 14387770.0; // Planck's second radiation constant [nm K]
// Wavelengths of the sum over the visible spectrum: the first, their distance [nm] and their number.
const FIRST_WAVELENGTH: f32 = 380.0;
const WAVELENGTH_STEP: f32 = 10.0;
const WAVELENGTHS: u32 = 41u;
const UNIT_RADIANCE: f32 = 423638.56; // of the sum, so that red is 1 at 1500 K
// Exponents of Planck's law between which exp(x) - 1 is representable.
const LEAST_POWER: f32 = 1e-3;
const MOST_POWER: f32 = 80.0;

// Radiance of a black body (Planck 1901) seen by the CIE 1931 observer: linear sRGB, as a share of red at
// 1500 K. Colours outside sRGB are clamped to it; 0 up to 0 K.
fn black_body(kelvin: f32) -> vec3<f32> {
    var seen = vec3(0.0);
    for (var i = 0u; i < WAVELENGTHS && kelvin > 0.0; i += 1u) {
        let nm = FIRST_WAVELENGTH + WAVELENGTH_STEP * f32(i);
        let power = clamp(RADIATION / (nm * kelvin), LEAST_POWER, MOST_POWER);
        let shorter = 600.0 / nm;
        let longer = shorter * shorter;
        seen += observer(nm) * (longer * longer * shorter / (exp(power) - 1.0));
    }
    // Linear sRGB (IEC 61966-2-1).
    let rgb = vec3(3.2406, -0.9689, 0.0557) * seen.x + vec3(-1.5372, 1.8758, -0.2040) * seen.y
        + vec3(-0.4986, 0.0415, 1.0570) * seen.z;
    return max(rgb * UNIT_RADIANCE, vec3(0.0));
}

// Colour matching functions of CIE 1931 (Wyman, Sloan and Shirley 2013, section 2.2).
fn observer(nm: f32) -> vec3<f32> {
    return vec3(
        lobe(nm, 1.056, 599.8, 37.9, 31.0)
            + lobe(nm, 0.362, 442.0, 16.0, 26.7)
            - lobe(nm, 0.065, 501.1, 20.4, 26.2),
        lobe(nm, 0.821, 568.8, 46.9, 40.5) + lobe(nm, 0.286, 530.9, 16.3, 31.1),
        lobe(nm, 1.217, 437.0, 11.8, 36.0) + lobe(nm, 0.681, 459.0, 26.0, 13.8),
    );
}

// A normal curve of two widths [nm].
fn lobe(nm: f32, height: f32, middle: f32, shorter: f32, longer: f32) -> f32 {
    let aside = (nm - middle) / select(longer, shorter, nm < middle);
    return height * exp(-0.5 * aside * aside);
}
