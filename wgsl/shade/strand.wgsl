// Light that a strand scatters and mirrors. CPU reference: crates/gobo-reference/src/shading/mod.rs.

import package::shade::shading::PER_PI;

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
    let mirrored = SHEEN * (1.0 + exponent * sines.x * sines.x) / (exponent + 2.0);
    return sines.x * PER_PI * ((1.0 - mirrored) * evenly + SHEEN * lobe);
}
