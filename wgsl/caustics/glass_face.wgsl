// A face of glass in the space of a light's rays, and the rays of its map. CPU reference:
// crates/gobo-reference/src/caustics.rs.

import package::bind::read::glass;
import package::bind::uniform::views;
import package::caustics::light_views::{from_view, in_rays, turned};
import package::records::glass::GLASS_VECTORS;

// Least weight of a corner: rounding leaves no gap between neighbours.
const LEAST_WEIGHT: f32 = -0.00001;
// Weights of corners beyond a face to which its normals are continued.
const FARTHEST_WEIGHT: f32 = 2.0;

struct GlassFace {
    corners: array<vec3<f32>, 3>, // [m]
    normal: vec3<f32>,            // of its plane, of any length
    ior: f32,                     // of green light
    spread: f32,                  // added to it for blue, and taken away for red
}

fn glass_face(number: u32) -> GlassFace {
    let first = glass[number * GLASS_VECTORS];
    let second = glass[number * GLASS_VECTORS + 1u];
    let a = in_rays(first.xyz);
    let b = in_rays(second.xyz);
    let c = in_rays(glass[number * GLASS_VECTORS + 2u].xyz);
    return GlassFace(array(a, b, c), cross(b - a, c - a), first.w, second.w);
}

// The ray through a point of a map.
struct LightRay {
    start: vec3<f32>,
    step: vec3<f32>, // per metre along the axis of the view
}

fn light_ray(number: u32, texel: vec2<f32>) -> LightRay {
    let view = views[number];
    let slope = (texel - view.size * 0.5) / view.scale;
    let aside = vec3(slope.x, -slope.y, 0.0);
    let ahead = vec3(0.0, 0.0, -1.0);
    let spreads = view.perspective > 0.0;
    let step = from_view(number, select(ahead, aside + ahead, spreads));
    return LightRay(select(aside, vec3(0.0), spreads), step);
}

// Weights of the corners at a point of the face's plane.
fn weights_at(face: GlassFace, point: vec3<f32>) -> vec3<f32> {
    let off = point - face.corners[0];
    let square = dot(face.normal, face.normal);
    let second = dot(cross(off, face.corners[2] - face.corners[0]), face.normal) / square;
    let third = dot(cross(face.corners[1] - face.corners[0], off), face.normal) / square;
    return vec3(1.0 - second - third, second, third);
}

struct Met {
    is_met: bool,
    along: f32,         // steps of the ray: for a map's, the distance along the axis [m]
    weights: vec3<f32>, // of the corners
}

fn meets_face(face: GlassFace, ray: LightRay) -> Met {
    let slope = dot(face.normal, ray.step);
    let along = dot(face.normal, face.corners[0] - ray.start) / slope;
    let is_met = slope != 0.0 && dot(face.normal, face.normal) > 0.0;
    return Met(is_met, along, weights_at(face, ray.start + ray.step * along));
}

// Unit normal of the face `number` at a point, on the side that a ray comes from.
fn glass_normal(number: u32, face: GlassFace, weights: vec3<f32>, ray: vec3<f32>) -> vec3<f32> {
    let near = clamp(weights, vec3(1.0 - FARTHEST_WEIGHT), vec3(FARTHEST_WEIGHT));
    let first = number * GLASS_VECTORS + 3u;
    let mixed = glass[first].xyz * near.x
        + glass[first + 1u].xyz * near.y
        + glass[first + 2u].xyz * near.z;
    let smooth_normal = turned(mixed);
    let flat_normal = select(-face.normal, face.normal, dot(face.normal, ray) < 0.0);
    let round = select(smooth_normal, -smooth_normal, dot(smooth_normal, flat_normal) < 0.0);
    let normal = select(flat_normal, round, dot(round, ray) < 0.0);
    let size = length(normal);
    return select(-ray, normal / max(size, 1e-30), size > 0.0);
}
