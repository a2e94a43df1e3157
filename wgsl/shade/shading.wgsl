// How what the camera sees scatters light to it. CPU twin: src/reference/shading/mod.rs.

import package::bind::uniform::picture_params;

const PER_PI: f32 = 0.31830989;

// What is seen, and mirrored, where there is nothing: brighter above.
fn sky(direction: vec3<f32>) -> vec3<f32> {
    return picture_params.background * (1.0 + 0.35 * direction.y);
}

const HEAD_ON: f32 = 0.04; // what glass mirrors that is looked at straight

// Schlick 1994, of glass and most that is no metal; `grazing`: what is mirrored at 90 degrees.
fn fresnel(cosine: f32, grazing: f32) -> f32 {
    let rest = clamp(1.0 - cosine, 0.0, 1.0);
    return HEAD_ON + (grazing - HEAD_ON) * rest * rest * rest * rest * rest;
}

// How much is mirrored: all of what reflects by itself, of the rest what shines like glass.
struct Gloss {
    reflectivity: f32,
    polish: f32, // 1 of glass, 0 of what is not there
}

fn mirrored(gloss: Gloss, cosine: f32) -> f32 {
    return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * fresnel(cosine, 1.0);
}

// As `mirrored`, of light from all around: what is rough has no grazing shine (Lagarde 2011).
fn mirrored_sky(gloss: Gloss, cosine: f32, roughness: f32) -> f32 {
    let share = fresnel(cosine, max(1.0 - roughness, HEAD_ON));
    return gloss.reflectivity + (1.0 - gloss.reflectivity) * gloss.polish * share;
}

// Blinn 1977, normalised; the exponent from the roughness as Walter et al. 2007, section 6.
fn highlight(normal: vec3<f32>, toward: vec3<f32>, to_eye: vec3<f32>, roughness: f32, gloss: Gloss) -> f32 {
    let middle = normalize(toward + to_eye);
    let width = max(roughness * roughness, 0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = pow(max(dot(normal, middle), 1e-6), exponent);
    return (exponent + 8.0) * (PER_PI / 8.0) * lobe * mirrored(gloss, dot(to_eye, middle));
}
