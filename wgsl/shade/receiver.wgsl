// Receivers, and the casters of a map that tint them. CPU reference:
// crates/gobo-reference/src/shading/receive.rs, `Plane`.

import package::bind::sampled::opaques;
import package::bind::uniform::picture_params;
import package::features::HAS_FAR_SIDES;
import package::records::material::{RECEIVES_OPAQUE, RECEIVES_OTHERS};
import package::records::texel::stored_tag;
import package::records::view::GpuView;

// Properties of the receiver that choose the casters that tint it, set before light is evaluated.

var<private> receives: u32;     // RECEIVES_*
var<private> receiver_tag: u32; // owner tag of its object
var<private> is_solid: bool;    // it is opaque: in no filter map, so it is none of the translucent casters
var<private> is_leaf: bool;     // it is in the filter map itself

fn set_receiver(accepts: u32, tag: u32, solid: bool) {
    receives = accepts;
    receiver_tag = tag;
    is_solid = solid;
}

fn set_leaf(leaf: bool) {
    is_leaf = leaf;
}

// Whether a texel's translucent casters tint the receiver at all. `filtered` and `nearest`: in the format of
// the maps.
fn is_tinted(filtered: vec4<f32>, nearest: f32) -> bool {
    let is_shown = (receives == RECEIVES_OTHERS) & (stored_tag(filtered.a, nearest) == receiver_tag);
    return (receives != RECEIVES_OPAQUE) & !is_shown;
}

// Depth of a receiver for translucent casters.

// Share of the bias by which an opaque receiver extends, so that casters that touch it tint it.
const TOUCH: f32 = 0.0625;
// Cosine between a plane's normal and a ray below which the plane has no depth along it.
const EDGE_ON: f32 = 0.02;

// Tangent plane of the receiver, view space.
var<private> plane_point: vec3<f32>;
var<private> plane_normal: vec3<f32>;

fn set_plane(view: GpuView, point: vec3<f32>, normal: vec3<f32>) {
    plane_point = (view.view_from_world * vec4(point, 1.0)).xyz;
    plane_normal = (view.view_from_world * vec4(normal, 0.0)).xyz;
}

// Light depth along the ray through `texel` (of the view's map) up to which translucent casters tint the
// receiver at `z`. An opaque receiver cannot tint itself: its depth is where its plane meets the ray, and
// slightly beyond, so that casters that touch it count. For a leaf it is less by the bias.
fn tint_depth(view: GpuView, texel: vec2<f32>, z: f32, bias: f32) -> f32 {
    let slope = (texel - view.size * 0.5) / view.scale;
    let perspective = view.perspective > 0.0;
    // Rays start at the eye, or in the eye's plane.
    let ray = select(vec3(0.0, 0.0, -1.0), vec3(slope.x, -slope.y, -1.0), perspective);
    let start = select(vec3(slope.x, -slope.y, 0.0), vec3(0.0), perspective);
    let meets = dot(plane_normal, ray);
    let edge_on = abs(meets) < EDGE_ON * length(ray);
    let met = dot(plane_normal, plane_point - start) / select(meets, 1.0, edge_on);
    let along = select(met, -plane_point.z, edge_on);
    let own = (along - view.near) / (view.far - view.near);
    let depth = own + TOUCH * bias;
    if HAS_FAR_SIDES {
        return select(select(z, own, is_leaf) - bias, depth, is_solid);
    }
    return select(z - bias, depth, is_solid);
}

// Opaque depth of a texel, per channel.
fn solid_depths(view: GpuView, at: vec2<u32>) -> vec3<f32> {
    let depths = textureLoad(opaques, at, view.layer, 0).rgb;
    return select(depths.rrr, depths, picture_params.colored != 0u);
}
