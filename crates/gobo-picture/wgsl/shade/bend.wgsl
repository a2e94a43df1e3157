// Refraction: the scene behind glass appears displaced, where the eye's ray enters a body, and blurred, by
// the roughness of panes, as in viewers of glTF (KHR_materials_transmission, KHR_materials_volume), but with
// the body's own thickness. CPU reference: crates/gobo-reference/src/refraction.rs.

import package::bind::uniform::materials;
import package::records::footprint::{BACK_BIT, setup_texel};
import package::records::view::GpuView;
import package::shade::layer::NOWHERE;
import package::shade::surface::world_point;

// Largest cosine between a ray and a face's normal for a ray that meets the face.
const MIN_LEAVING: f32 = -0.05;

var<private> aside: vec2<f32>;      // place where the scene behind is seen, from the pixel [pixels]
var<private> blur_square: f32;      // square of the blur's radius [pixels^2]
var<private> entered: f32;          // light depth where the ray entered a body; NOWHERE outside
var<private> bent: vec3<f32>;       // its direction inside, unit, world space

fn start_bend() {
    aside = vec2(0.0);
    blur_square = 0.0;
    entered = NOWHERE;
}

fn depth_range(view: GpuView) -> f32 {
    return view.far - view.near;
}

// The ray leaves its body at light depth `depth`; `share`: its length inside, as a share of the straight
// ray's.
fn leave(view: GpuView, pixel: vec2<f32>, depth: f32, share: f32) {
    let slope = (pixel - view.size * 0.5) / view.scale;
    let length = share * (depth - entered) * depth_range(view) * sqrt(1.0 + dot(slope, slope));
    let position = world_point(view, pixel, entered) + bent * length;
    let seen = (view.view_from_world * vec4(position, 1.0)).xyz;
    aside += vec2(seen.x, -seen.y) * (view.scale / max(-seen.z, view.near)) + view.size * 0.5 - pixel;
    entered = NOWHERE;
}

// The ray meets a pane in front of the surface at light depth `behind`; `normal`: on the eye's side.
fn bend(
    view: GpuView,
    pixel: vec2<f32>,
    setup: u32,
    depth: f32,
    behind: f32,
    normal: vec3<f32>,
    to_eye: vec3<f32>,
) {
    let material = materials[setup_texel(setup, 4u).w];
    let range = depth_range(view);
    let blur = material.frost * (behind - depth) * range / (view.near + behind * range) * view.scale;
    blur_square += blur * blur;
    if material.ior <= 1.0 {
        return;
    }
    let leaves = (setup_texel(setup, 3u).w & BACK_BIT) != 0u;
    if leaves && entered < NOWHERE {
        // Up to the plane of the face.
        leave(
            view,
            pixel,
            depth,
            clamp(-dot(normal, to_eye) / min(dot(normal, bent), MIN_LEAVING), 0.5, 1.5),
        );
    } else if !leaves && entered >= NOWHERE {
        entered = depth;
        bent = refract(-to_eye, normal, 1.0 / material.ior);
    }
}

// Place and blur of the scene behind all panes, at light depth `behind`.
fn bent_by(view: GpuView, pixel: vec2<f32>, behind: f32) -> vec4<u32> {
    if entered < NOWHERE && behind < 1.0 {
        leave(view, pixel, behind, 1.0);
    }
    return vec4(bitcast<vec2<u32>>(aside), bitcast<u32>(sqrt(blur_square)), 0u);
}
