// Scattering and reflection towards the camera. CPU reference: crates/gobo-reference/src/shading/mod.rs,
// crates/gobo-reference/src/air.rs, crates/gobo-reference/src/shading/mod.rs, src/model/environment.rs.

import package::bind::uniform::picture_params;

const PER_PI: f32 = 0.31830989;

const HEAD_ON: f32 = 0.04; // reflectance of glass at normal incidence

// Fresnel reflectance (Schlick 1994) of dielectrics such as glass; `grazing`: reflectance at 90 degrees.
fn fresnel(cosine: f32, grazing: f32) -> f32 {
    return HEAD_ON + (grazing - HEAD_ON) * rising(cosine);
}

// Schlick's weight: 0 head-on, 1 at 90 degrees.
fn rising(cosine: f32) -> f32 {
    let rest = clamp(1.0 - cosine, 0.0, 1.0);
    return rest * rest * rest * rest * rest;
}

// Reflectance of an opaque surface for the environment; metal has its own colour. `grazing` as in
// `mirrored_sky`.
fn mirrored_solid(albedo: vec3<f32>, metallic: f32, cosine: f32, roughness: f32) -> vec3<f32> {
    let head_on = mix(vec3(HEAD_ON), albedo, metallic);
    return head_on + (max(vec3(1.0 - roughness), head_on) - head_on) * rising(cosine);
}

// Mirrored share of light: in full by reflectivity, the rest by polish like glass.
struct Gloss {
    reflectivity: f32,
    polish: f32, // 1 for glass, 0 for a surface of no coverage
}

// `head_on`: reflectance at 0 degrees.
fn mirrored(gloss: Gloss, cosine: f32, head_on: vec3<f32>) -> vec3<f32> {
    let share = head_on + (1.0 - head_on) * rising(cosine);
    return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * share;
}

// Like `mirrored`, for light from the environment: rough surfaces have no grazing reflection (Lagarde
// 2011).
fn mirrored_sky(gloss: Gloss, cosine: f32, roughness: f32) -> f32 {
    let share = fresnel(cosine, max(1.0 - roughness, HEAD_ON));
    return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * share;
}

// Specular highlight: Blinn 1977, normalised so that it sends out all light that arrives head-on, and never
// more; the exponent follows from the roughness as in Walter et al. 2007, section 6. Per unit of reflectance.
// `middle`: unit half vector between the directions to the light and to the eye.
fn highlight(normal: vec3<f32>, middle: vec3<f32>, roughness: f32) -> f32 {
    let width = max(roughness * roughness, 0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = pow(max(dot(normal, middle), 1e-6), exponent);
    return (exponent + 6.0) * (PER_PI / 8.0) * lobe;
}

// Light that a strand scatters and mirrors.

const HALF_TURN: f32 = 3.14159265;
// Share of light in the highlight of hair, in the hair's own colour: 0.04 at its surface, and light from its
// inside.
const SHEEN: f32 = 0.2;

// Share of the light from `toward` that a strand of albedo 1 along `axis` sends to the eye: that of an evenly
// scattering cylinder, over its width, and a highlight along the cone of mirrored light (Kajiya and Kay
// 1989), which the rest loses.
fn strand_scattered(axis: vec3<f32>, toward: vec3<f32>, to_eye: vec3<f32>, roughness: f32) -> f32 {
    let along = vec2(dot(axis, toward), dot(axis, to_eye));
    let sines = sqrt(max(1.0 - along * along, vec2(1e-6)));
    let cosine = (dot(toward, to_eye) - along.x * along.y) / (sines.x * sines.y);
    let angle = acos(clamp(cosine, -1.0, 1.0));
    let evenly = ((HALF_TURN - angle) * cos(angle) + sin(angle)) * 0.25;
    let width = max(roughness * roughness, 0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let power = pow(max(sines.x * sines.y - along.x * along.y, 1e-6), exponent);
    // The integral of a cosine's power is sqrt(2 pi / (exponent + 0.5)), slightly less for small exponents.
    let lobe = 0.5 * sqrt((exponent + 0.5) * (0.5 * PER_PI)) * power;
    // The highlight's cone appears as wide as the strand itself: the mean square of the sine over the lobe.
    let shine = SHEEN * (1.0 + exponent * sines.x * sines.x) / (exponent + 2.0);
    return sines.x * PER_PI * ((1.0 - shine) * evenly + SHEEN * lobe);
}

// Scattering by particles and media.

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

// Irradiance of a surface of normal `n`, divided by pi: spherical harmonics up to order 2 (Ramamoorthi and
// Hanrahan 2001).
fn irradiance(n: vec3<f32>) -> vec3<f32> {
    let linear = coefficient(0u) + coefficient(1u) * n.y + coefficient(2u) * n.z + coefficient(3u) * n.x;
    let mixed = coefficient(4u) * (n.x * n.y) + coefficient(5u) * (n.y * n.z) + coefficient(7u) * (n.x * n.z);
    let squares = coefficient(6u) * (3.0 * n.z * n.z - 1.0) + coefficient(8u) * (n.x * n.x - n.y * n.y);
    return max(linear + mixed + squares, vec3(0.0));
}

fn coefficient(i: u32) -> vec3<f32> {
    return picture_params.irradiance[i].rgb;
}
