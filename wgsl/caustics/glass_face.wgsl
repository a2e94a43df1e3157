// A face of glass in a light's view, and the rays of its map. CPU reference:
// crates/gobo-reference/src/caustics.rs.

import package::bind::read::glass;
import package::records::glass::GLASS_VECTORS;
import package::records::view::GpuView;

// Least weight of a corner: rounding leaves no gap between neighbours.
const LEAST_WEIGHT: f32 = -0.00001;

struct GlassFace {
    corners: array<vec3<f32>, 3>, // view space [m]
    normal: vec3<f32>,            // of its plane, of any length
    ior: f32,
}

fn glass_face(view: GpuView, number: u32) -> GlassFace {
    let first = glass[number * GLASS_VECTORS];
    let a = (view.view_from_world * vec4(first.xyz, 1.0)).xyz;
    let b = (view.view_from_world * vec4(glass[number * GLASS_VECTORS + 1u].xyz, 1.0)).xyz;
    let c = (view.view_from_world * vec4(glass[number * GLASS_VECTORS + 2u].xyz, 1.0)).xyz;
    return GlassFace(array(a, b, c), cross(b - a, c - a), first.w);
}

// The ray through a point of the map, view space.
struct LightRay {
    start: vec3<f32>,
    step: vec3<f32>, // per metre along the axis
}

fn light_ray(view: GpuView, texel: vec2<f32>) -> LightRay {
    let slope = (texel - view.size * 0.5) / view.scale;
    let aside = vec3(slope.x, -slope.y, 0.0);
    let ahead = vec3(0.0, 0.0, -1.0);
    let spreads = view.perspective > 0.0;
    return LightRay(select(aside, vec3(0.0), spreads), select(ahead, aside + ahead, spreads));
}

// Place of a view-space point in the map [texels].
fn map_place(view: GpuView, point: vec3<f32>) -> vec2<f32> {
    let spread = view.scale / select(1.0, max(-point.z, 1e-6), view.perspective > 0.0);
    return vec2(point.x, -point.y) * spread + view.size * 0.5;
}

// Edge of a texel at a view-space point [m].
fn texel_at(view: GpuView, point: vec3<f32>) -> f32 {
    return select(1.0, -point.z, view.perspective > 0.0) / view.scale;
}

struct Met {
    is_met: bool,
    along: f32,         // distance along the axis [m]
    weights: vec3<f32>, // of the corners
}

fn meets_face(face: GlassFace, ray: LightRay) -> Met {
    let slope = dot(face.normal, ray.step);
    let along = dot(face.normal, face.corners[0] - ray.start) / slope;
    let off = ray.start + ray.step * along - face.corners[0];
    let square = dot(face.normal, face.normal);
    let second = dot(cross(off, face.corners[2] - face.corners[0]), face.normal) / square;
    let third = dot(cross(face.corners[1] - face.corners[0], off), face.normal) / square;
    return Met(slope != 0.0 && square > 0.0, along, vec3(1.0 - second - third, second, third));
}

// Unit normal of the face `number` at a point, on the side that a ray comes from.
fn glass_normal(
    view: GpuView,
    number: u32,
    face: GlassFace,
    weights: vec3<f32>,
    ray: vec3<f32>,
) -> vec3<f32> {
    let inner = max(weights, vec3(0.0));
    let first = number * GLASS_VECTORS + 3u;
    let mixed = glass[first].xyz * inner.x
        + glass[first + 1u].xyz * inner.y
        + glass[first + 2u].xyz * inner.z;
    let turned = (view.view_from_world * vec4(mixed, 0.0)).xyz;
    let flat = select(-face.normal, face.normal, dot(face.normal, ray) < 0.0);
    let round = select(turned, -turned, dot(turned, flat) < 0.0);
    let normal = select(flat, round, dot(round, ray) < 0.0);
    let size = length(normal);
    return select(-ray, normal / max(size, 1e-30), size > 0.0);
}
