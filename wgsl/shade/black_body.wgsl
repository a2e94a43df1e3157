// Light of what is hot. CPU reference: src/model/black_body.rs.

const WAVELENGTH_RED: f32 = 0.6114; // [um]
const WAVELENGTH_GREEN: f32 = 0.5491;
const WAVELENGTH_BLUE: f32 = 0.4643;
const RADIATION: f32 = 14387.77;        // Planck's second radiation constant [um K]
const UNIT_TEMPERATURE: f32 = 1500.0; // at which red is 1 [K]

// Radiance of a black body (Planck 1901) at the wavelengths of red, green and blue, as a share of that of red at
// 1500 K; 0 up to 0 K.
fn black_body(kelvin: f32) -> vec3<f32> {
    let wavelengths = vec3(WAVELENGTH_RED, WAVELENGTH_GREEN, WAVELENGTH_BLUE);
    let unit = exp(RADIATION / (WAVELENGTH_RED * UNIT_TEMPERATURE)) - 1.0;
    // Numbers do not hold the power of more.
    let power = min(RADIATION / (wavelengths * max(kelvin, 1.0)), vec3(80.0));
    let longer = WAVELENGTH_RED / wavelengths;
    let radiance = longer * longer * longer * longer * longer * unit / (exp(power) - 1.0);
    return select(vec3(0.0), radiance, kelvin > 0.0);
}
