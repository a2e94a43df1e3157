// Light that a brick sends along a ray to the eye: what its lattice of points scatters at four places of the ray, by
// what the ray absorbs near each. CPU reference: src/reference/brick_light.rs.

import package::bind::sampled::brick_lights;
import package::records::brick::{LATTICE_EDGE, LATTICE_POINTS};
import package::records::record::record_texel;

// The kernel shades bricks.
override SHADES_BRICKS: bool = false;

var<private> weights: array<vec3<f32>, 4>; // absorbed near each place, of the light from behind
var<private> left: vec3<f32>;              // of that light, in front of what is weighed next
var<private> enters: vec3<f32>;            // where the ray enters the box, 0..1
var<private> leaves: vec3<f32>;
var<private> first_point: u32;

fn start_weights(id: u32) {
    first_point = id * LATTICE_POINTS;
    weights[0] = vec3(0.0);
    weights[1] = vec3(0.0);
    weights[2] = vec3(0.0);
    weights[3] = vec3(0.0);
    left = vec3(1.0);
}

fn along_ray(start: vec3<f32>, end: vec3<f32>) {
    enters = start;
    leaves = end;
}

// The next part of the ray, of optical depth `tau`, with its middle at `part` of the way through the box.
fn weigh(tau: vec3<f32>, part: f32) {
    let passed = exp(-tau);
    let absorbed = left * (1.0 - passed);
    let near = max(1.0 - abs(3.0 * part - vec4(0.0, 1.0, 2.0, 3.0)), vec4(0.0));
    weights[0] += absorbed * near.x;
    weights[1] += absorbed * near.y;
    weights[2] += absorbed * near.z;
    weights[3] += absorbed * near.w;
    left *= passed;
}

fn point_light_at(index: u32) -> vec3<f32> {
    return textureLoad(brick_lights, record_texel(index), 0).rgb;
}

// Trilinear between the points of the lattice.
fn lattice_light(part: f32) -> vec3<f32> {
    let last = f32(LATTICE_EDGE - 1u);
    let at = clamp(mix(enters, leaves, part), vec3(0.0), vec3(1.0)) * last;
    let low = min(floor(at), vec3(last - 1.0));
    let aside = at - low;
    let cell = vec3<u32>(low);
    let row = LATTICE_EDGE;
    let layer = LATTICE_EDGE * LATTICE_EDGE;
    let own = first_point + cell.x + cell.y * row + cell.z * layer;
    let a = mix(point_light_at(own), point_light_at(own + 1u), aside.x);
    let b = mix(point_light_at(own + row), point_light_at(own + row + 1u), aside.x);
    let c = mix(point_light_at(own + layer), point_light_at(own + layer + 1u), aside.x);
    let d = mix(point_light_at(own + layer + row), point_light_at(own + layer + row + 1u), aside.x);
    return mix(mix(a, b, aside.y), mix(c, d, aside.y), aside.z);
}

// Mean light of what the ray has met, by what was absorbed there.
fn brick_light() -> vec3<f32> {
    let all = weights[0] + weights[1] + weights[2] + weights[3];
    let third = 1.0 / 3.0;
    let sum = weights[0] * lattice_light(0.0) + weights[1] * lattice_light(third)
        + weights[2] * lattice_light(2.0 * third) + weights[3] * lattice_light(1.0);
    return sum / max(all, vec3(1e-20));
}
