// Light that a strand scatters and mirrors. CPU reference: src/reference/shading/mod.rs.

import package::shade::shading::PER_PI;

const HALF_TURN: f32 = 3.14159265;
const SHEEN: f32 = 0.2; // highlight of hair, in its own colour: 0.04 at its surface and what its inside sends back

// Share of the light from `toward` that a strand of albedo 1 along `axis` sends to the eye: of a cylinder that scatters
// evenly, over its width, and a highlight along the cone of mirrored light (Kajiya and Kay 1989).
fn strand_scattered(axis: vec3<f32>, toward: vec3<f32>, to_eye: vec3<f32>, roughness: f32) -> f32 {
    let along = vec2(dot(axis, toward), dot(axis, to_eye));
    let sines = sqrt(max(1.0 - along * along, vec2(1e-6)));
    let cosine = (dot(toward, to_eye) - along.x * along.y) / (sines.x * sines.y);
    let angle = acos(clamp(cosine, -1.0, 1.0));
    let evenly = ((HALF_TURN - angle) * cos(angle) + sin(angle)) * 0.25;
    let width = max(roughness * roughness, 0.04);
    let exponent = 2.0 / (width * width) - 1.0;
    let lobe = pow(max(sines.x * sines.y - along.x * along.y, 1e-6), exponent);
    return sines.x * PER_PI * (evenly + SHEEN * (exponent + 8.0) * 0.125 * lobe);
}
