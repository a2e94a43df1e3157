// Volumes along the eye's ray, between the layers of four pixels. CPU twin:
// src/reference/shade/layers.rs.

import package::bind::uniform::materials;
import package::records::setup::{BACK_BIT, setup_texel};
import package::records::view::GpuView;

var<private> inside: array<vec3<f32>, 4>; // absorption where the ray is [1/m]
var<private> reached: vec4<f32>;          // light depth so far
var<private> metres: vec4<f32>;           // of the ray, per light depth
var<private> whole: bool;                 // the walk starts at the eye and ends at the surface

fn start_fog(view: GpuView, pixel: vec2<f32>, i: u32) {
    inside[i] = vec3(0.0);
    reached[i] = 0.0;
    let slope = (pixel - view.size * 0.5) / view.scale;
    metres[i] = (view.far - view.near) * sqrt(1.0 + dot(slope, slope));
}

// What passes from where the ray was to light depth `depth`.
fn fog_to(i: u32, depth: f32) -> vec3<f32> {
    let length = max(depth - reached[i], 0.0) * metres[i];
    reached[i] = max(reached[i], depth);
    return exp(-inside[i] * length);
}

// Past a face of a triangle: what it takes from what is behind.
fn cross_face(i: u32, setup: u32, depth: f32) -> vec3<f32> {
    let absorption = materials[setup_texel(setup, 4u).w].absorption;
    if (setup_texel(setup, 3u).w & BACK_BIT) == 0u {
        inside[i] += absorption;
        return vec3(1.0);
    }
    // The eye is inside what was not entered.
    let entered = all(inside[i] >= absorption * 0.999);
    inside[i] = select(inside[i], max(inside[i] - absorption, vec3(0.0)), entered);
    let way = select(depth * metres[i], 0.0, entered || !whole);
    return exp(-absorption * way);
}
