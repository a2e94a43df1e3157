// Glass that refracts light, and the light that it throws. CPU reference:
// crates/gobo-reference/src/caustics.rs. Rust: src/records/caustic.rs, src/stage/caustics.rs.

import package::bind::changed::{glass_depths, glass_owners};
import package::bind::read::glass;
import package::bind::sampled::opaques;
import package::bind::uniform::{caustic_params, views};
import package::records::view::GpuView;

const GLASS_VECTORS: u32 = 6u; // of a face: three corners [m], the first's w its index of refraction; normals

// Light of one texel, in fixed point.
const CAUSTIC_ONE: f32 = 65536.0;
// Bits of a channel's carry, in the last word of a texel.
const CARRY_BITS: u32 = 10u;
// Flag in the last word of a texel whose own light was thrown elsewhere.
const THROWN_BIT: u32 = 0x80000000u;
// Largest distance of a receiver from the opaque surface that light lands on [texels].
const NEAR_SURFACE: f32 = 4.0;

// Map of a view whose rays glass refracts.
struct CausticParams {
    first: u32,      // first texel of `caustics`
    face_count: u32,
    rays: u32,       // of a texel, along its edge
    slices: u32,     // workgroups of a face
}

// Light that lands in a texel, and 1 where the texel's own light was thrown elsewhere, else 0.
fn caustic_light(texel: vec4<u32>) -> vec4<f32> {
    let mask = (1u << CARRY_BITS) - 1u;
    let carries = (vec3(texel.w) >> vec3(0u, CARRY_BITS, 2u * CARRY_BITS)) & vec3(mask);
    return vec4(vec3<f32>(texel.xyz) / CAUSTIC_ONE + vec3<f32>(carries) * CAUSTIC_ONE, f32(texel.w >> 31u));
}

// A face of glass in a light's view, and the rays of its map.

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

override WORKGROUP_SIZE: u32;
override FINDS_OWNERS: bool;

// Distance behind a lamp's position from which a face has no place in its map [m].
const AHEAD: f32 = 0.0001;

// caustics, faces: the nearest face of glass in each texel of a view's map by which light enters a body, and
// the nearest by which it leaves one: first their depths, then the indices of the faces with these depths.
// The workgroups of a face take turns with its texels.
@compute @workgroup_size(WORKGROUP_SIZE)
fn glass_faces(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let number = workgroup.y * workgroups.x + workgroup.x;
    let view = views[0];
    if number >= caustic_params.face_count {
        return;
    }
    let face = glass_face(view, number);
    let nearest = max(max(face.corners[0].z, face.corners[1].z), face.corners[2].z);
    if (view.perspective > 0.0) & (nearest > -AHEAD) {
        return;
    }
    let a = map_place(view, face.corners[0]);
    let b = map_place(view, face.corners[1]);
    let c = map_place(view, face.corners[2]);
    let least = vec2<u32>(clamp(floor(min(min(a, b), c)), vec2(0.0), view.size));
    let last = vec2<u32>(clamp(ceil(max(max(a, b), c)), vec2(0.0), view.size));
    if any(last <= least) {
        return;
    }
    let size = last - least;
    let width = u32(view.size.x);
    for (
        var i = workgroup.z * WORKGROUP_SIZE + lane;
        i < size.x * size.y;
        i += caustic_params.slices * WORKGROUP_SIZE
    ) {
        let texel = least + vec2(i % size.x, i / size.x);
        let ray = light_ray(view, vec2<f32>(texel) + 0.5);
        let met = meets_face(face, ray);
        let depth = (met.along - view.near) / (view.far - view.near);
        let leaves = dot(face.normal, ray.step) > 0.0;
        let opaque = textureLoad(opaques, view.origin + texel, view.layer, 0).r;
        let inside = min(min(met.weights.x, met.weights.y), met.weights.z) >= LEAST_WEIGHT;
        if met.is_met && inside && depth >= 0.0 && depth < opaque {
            let at = 2u * (texel.y * width + texel.x) + select(0u, 1u, leaves);
            // Nearer is larger, and nothing is 0.
            let nearness = ~bitcast<u32>(depth);
            if !FINDS_OWNERS {
                atomicMax(&glass_depths[at], nearness);
            } else if atomicLoad(&glass_depths[at]) == nearness {
                atomicMax(&glass_owners[at], ~number);
            }
        }
    }
}
