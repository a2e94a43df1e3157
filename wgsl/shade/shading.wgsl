// How what the camera sees scatters light to it. CPU twin: src/reference/shading/mod.rs.

const PER_PI: f32 = 0.31830989;

const HEAD_ON: f32 = 0.04; // what glass mirrors that is looked at straight

// Schlick 1994, of glass and most that is no metal; `grazing`: what is mirrored at 90 degrees.
fn fresnel(cosine: f32, grazing: f32) -> f32 {
    return HEAD_ON + (grazing - HEAD_ON) * rising(cosine);
}

// From 0 head-on to 1 at 90 degrees.
fn rising(cosine: f32) -> f32 {
    let rest = clamp(1.0 - cosine, 0.0, 1.0);
    return rest * rest * rest * rest * rest;
}

// What is solid mirrors of light from all around; metal in its own colour. `grazing` as in `mirrored_sky`.
fn mirrored_solid(albedo: vec3<f32>, metallic: f32, cosine: f32, roughness: f32) -> vec3<f32> {
    let head_on = mix(vec3(HEAD_ON), albedo, metallic);
    return head_on + (max(vec3(1.0 - roughness), head_on) - head_on) * rising(cosine);
}

// How much is mirrored: all of what reflects by itself, of the rest what shines like glass.
struct Gloss {
    reflectivity: f32,
    polish: f32, // 1 of glass, 0 of what is not there
}

// `head_on`: mirrored at 0 degrees.
fn mirrored(gloss: Gloss, cosine: f32, head_on: vec3<f32>) -> vec3<f32> {
    let share = head_on + (1.0 - head_on) * rising(cosine);
    return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * share;
}

// As `mirrored`, of light from all around: what is rough has no grazing shine (Lagarde 2011).
fn mirrored_sky(gloss: Gloss, cosine: f32, roughness: f32) -> f32 {
    let share = fresnel(cosine, max(1.0 - roughness, HEAD_ON));
    return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * share;
}

// Blinn 1977, normalised; the exponent from the roughness as Walter et al. 2007, section 6.
// Per unit of what is mirrored; `middle` between the ways to the light and to the eye, unit.
fn highlight(normal: vec3<f32>, middle: vec3<f32>, roughness: f32) -> f32 {
    let width = max(roughness * roughness, 0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = pow(max(dot(normal, middle), 1e-6), exponent);
    return (exponent + 8.0) * (PER_PI / 8.0) * lobe;
}
