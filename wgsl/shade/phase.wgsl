// Scattering by particles and media. CPU reference: crates/gobo-reference/src/air.rs,
// crates/gobo-reference/src/shading/mod.rs.

const PER_FOUR_PI: f32 = 0.07957747;
// Orders of scattering in a brick.
const ORDERS: u32 = 4u;
// Transmittance that maps store as 0: 1/1024.
const DARKEST: f32 = 0.0009765625;

// Phase function of Henyey and Greenstein 1941; `cosine` between the incoming and outgoing directions.
fn phase(cosine: f32, g: f32) -> f32 {
    let spread = max(1.0 + g * g - 2.0 * g * cosine, 1e-6);
    return PER_FOUR_PI * (1.0 - g * g) / (spread * sqrt(spread));
}

// Share of the light that a point scatters to the eye, once and more often; `passed`: share that reaches it
// straight (Wrenninge, Kulla and Lundqvist 2013, "Oz: the great and volumetric", with a = c = 1/2): each
// order meets half the optical depth, and forgets half of the direction. Unlike the paper: an order adds only
// a part of the light it meets beyond the order before, so that where nothing is lost, light is scattered by
// the phase function alone, and nowhere more; b is half the albedo, so that dark smoke scatters once; and
// light that maps store as 0 is 0 without a step.
fn phase_of_orders(passed: vec3<f32>, cosine: f32, g: f32, albedo: vec3<f32>) -> vec3<f32> {
    var light = max(passed - DARKEST, vec3(0.0)) / (1.0 - DARKEST);
    var before = vec3(0.0);
    var share = vec3(1.0);
    var sum = vec3(0.0);
    var lobe = g;
    for (var order = 0u; order < ORDERS; order += 1u) {
        sum += share * max(light - before, vec3(0.0)) * phase(cosine, lobe);
        before = light;
        light = sqrt(light);
        share *= 0.5 * albedo;
        lobe *= 0.5;
    }
    return sum;
}
