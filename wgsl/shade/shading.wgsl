// Scattering and reflection towards the camera. CPU reference: crates/gobo-reference/src/shading/mod.rs.

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
