// Rays of the camera. CPU reference: crates/gobo-reference/src/shade/layers.rs.

import package::bind::picture_out::carried;
import package::bind::uniform::{materials, views};
import package::features::COUNT_COST;
import package::records::footprint::{BACK_BIT, setup_texel};
import package::records::view::GpuView;

// The camera's view.
fn camera() -> GpuView {
    var view = views[0];
    // Not by `views` alone: lavapipe recompiles a kernel for every picture where a uniform buffer decides a
    // branch.
    view.perspective = select(0.0, view.perspective, arrayLength(&carried) > 0u);
    return view;
}

// Cost counters of a pixel, for --debug cost, where they replace its colour.

var<private> walked: u32; // pairs that the invocation visited

fn count_pair() {
    if COUNT_COST {
        walked += 1u;
    }
}

// Volumes along the eye's ray, between the layers of a pixel.

var<private> inside: vec3<f32>; // absorption coefficient at the ray's present depth [1/m]
var<private> reached: f32;      // light depth reached so far
var<private> metres: f32;       // length of the ray per unit of light depth

fn start_fog(view: GpuView, pixel: vec2<f32>) {
    inside = vec3(0.0);
    reached = 0.0;
    let slope = (pixel - view.size * 0.5) / view.scale;
    metres = (view.far - view.near) * sqrt(1.0 + dot(slope, slope));
}

// Advances to light depth `depth`; returns the transmittance of the stretch.
fn fog_to(depth: f32) -> vec3<f32> {
    let length = max(depth - reached, 0.0) * metres;
    reached = max(reached, depth);
    return exp(-inside * length);
}

// Crosses a triangle's face; returns its transmittance for the light behind.
fn cross_face(setup: u32, depth: f32) -> vec3<f32> {
    let absorption = materials[setup_texel(setup, 4u).w].absorption;
    if (setup_texel(setup, 3u).w & BACK_BIT) == 0u {
        inside += absorption;
        return vec3(1.0);
    }
    // Otherwise the eye is inside a volume that was not entered.
    let entered = all(inside >= absorption * 0.999);
    inside = select(inside, max(inside - absorption, vec3(0.0)), entered);
    return exp(-absorption * select(depth * metres, 0.0, entered));
}
