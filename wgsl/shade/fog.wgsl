// Volumes along the eye's ray, between the layers of a pixel. CPU twin: src/reference/shade/layers.rs.

import package::bind::uniform::materials;
import package::records::setup::{BACK_BIT, setup_texel};
import package::records::view::GpuView;

var<private> inside: vec3<f32>; // absorption where the ray is [1/m]
var<private> reached: f32;      // light depth so far
var<private> metres: f32;       // of the ray, per light depth

fn start_fog(view: GpuView, pixel: vec2<f32>) {
    inside = vec3(0.0);
    reached = 0.0;
    let slope = (pixel - view.size * 0.5) / view.scale;
    metres = (view.far - view.near) * sqrt(1.0 + dot(slope, slope));
}

// What passes from where the ray was to light depth `depth`.
fn fog_to(depth: f32) -> vec3<f32> {
    let length = max(depth - reached, 0.0) * metres;
    reached = max(reached, depth);
    return exp(-inside * length);
}

// Past a face of a triangle: what it takes from what is behind.
fn cross_face(setup: u32, depth: f32) -> vec3<f32> {
    let absorption = materials[setup_texel(setup, 4u).w].absorption;
    if (setup_texel(setup, 3u).w & BACK_BIT) == 0u {
        inside += absorption;
        return vec3(1.0);
    }
    // The eye is inside what was not entered.
    let entered = all(inside >= absorption * 0.999);
    inside = select(inside, max(inside - absorption, vec3(0.0)), entered);
    return exp(-absorption * select(depth * metres, 0.0, entered));
}
