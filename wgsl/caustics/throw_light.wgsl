// Light that glass refracts, to the surfaces where it lands. CPU reference:
// crates/gobo-reference/src/caustics.rs. Rust: src/stage/caustics.rs.

import package::bind::changed::caustics;
import package::bind::read::{glass_depths, glass_owners};
import package::bind::sampled::{filters, opaques};
import package::bind::uniform::{caustic_params, views};
import package::caustics::glass::{
    CARRY_BITS, CAUSTIC_ONE, NEAR_SURFACE, THROWN_BIT, glass_face, glass_normal, light_ray, map_place,
    meets_face, texel_at,
};
import package::records::view::GpuView;

// Place where a ray that glass refracts lands.

// Doublings of the distance inside a body until the ray is out of it.
const DOUBLINGS: u32 = 16u;
// Halvings that find a crossing.
const HALVINGS: u32 = 14u;
// Steps from glass to the far plane.
const LANDING_STEPS: u32 = 64u;

// A place in the map [texels], or a point on a face; or none.
struct Landed {
    is_there: bool,
    at: vec2<f32>,
}

struct Left {
    is_there: bool,
    point: vec3<f32>,
    face: u32,
}

struct Bent {
    passes: bool,
    ray: vec3<f32>,
}

fn is_on_map(view: GpuView, place: vec2<f32>) -> bool {
    return all(place >= vec2(0.0)) && all(place < view.size);
}

fn texel_index(view: GpuView, place: vec2<f32>) -> u32 {
    let texel = vec2<u32>(clamp(place, vec2(0.0), view.size - 1.0));
    return texel.y * u32(view.size.x) + texel.x;
}

// Snell's law for unit vectors; `ratio` of the refractive indices, `normal` on the ray's side. Nothing passes
// at total reflection.
fn bent(ray: vec3<f32>, normal: vec3<f32>, ratio: f32) -> Bent {
    let cosine = -dot(ray, normal);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    let through = ray * ratio + normal * (ratio * cosine - sqrt(max(rest, 0.0)));
    return Bent(rest >= 0.0, normalize(through));
}

// Depth of the nearest face by which light leaves a body at a point's texel, minus the point's depth; below 0
// outside all bodies.
fn left_depth(view: GpuView, point: vec3<f32>) -> f32 {
    let place = map_place(view, point);
    let at = 2u * texel_index(view, place) + 1u;
    let depth = bitcast<f32>(~glass_depths[at]);
    let own = (-point.z - view.near) / (view.far - view.near);
    return select(-1.0, depth - own, is_on_map(view, place) && glass_owners[at] != 0u);
}

// Place where a ray inside a body leaves it, and the face; `is_there` is false for a surface without a body
// behind it.
fn way_out(view: GpuView, start: vec3<f32>, ray: vec3<f32>) -> Left {
    let place = map_place(view, start);
    if !is_on_map(view, place) || glass_owners[2u * texel_index(view, place) + 1u] == 0u {
        return Left(false, start, 0u);
    }
    var near = 0.0;
    var far = texel_at(view, start);
    for (var i = 0u; i < DOUBLINGS; i += 1u) {
        if left_depth(view, start + ray * far) < 0.0 {
            break;
        }
        near = far;
        far *= 2.0;
    }
    for (var i = 0u; i < HALVINGS; i += 1u) {
        let middle = 0.5 * (near + far);
        let is_out = left_depth(view, start + ray * middle) < 0.0;
        near = select(middle, near, is_out);
        far = select(far, middle, is_out);
    }
    let point = start + ray * near;
    let end = map_place(view, point);
    let owner = glass_owners[2u * texel_index(view, end) + 1u];
    return Left(is_on_map(view, end) && owner != 0u, point, ~owner);
}

// Depth of a point minus that of the opaque surface at its texel [m].
fn behind_opaque(view: GpuView, point: vec3<f32>) -> f32 {
    let texel = vec2<u32>(clamp(map_place(view, point), vec2(0.0), view.size - 1.0));
    let depth = textureLoad(opaques, view.origin + texel, view.layer, 0).r;
    return -point.z - (view.near + depth * (view.far - view.near));
}

// First place where a ray meets the opaque depths.
fn meets_opaque(view: GpuView, start: vec3<f32>, ray: vec3<f32>) -> Landed {
    let nowhere = Landed(false, vec2(0.0));
    if ray.z >= 0.0 {
        return nowhere;
    }
    let step = (view.far + start.z) / (f32(LANDING_STEPS) * -ray.z);
    var before = false;
    for (var i = 0u; i <= LANDING_STEPS; i += 1u) {
        let along = step * f32(i);
        if !is_on_map(view, map_place(view, start + ray * along)) {
            return nowhere;
        }
        let is_behind = behind_opaque(view, start + ray * along) >= 0.0;
        if is_behind && !before {
            var near = max(along - step, 0.0);
            var far = along;
            for (var k = 0u; k < HALVINGS; k += 1u) {
                let middle = 0.5 * (near + far);
                let is_past = behind_opaque(view, start + ray * middle) >= 0.0;
                near = select(middle, near, is_past);
                far = select(far, middle, is_past);
            }
            let point = start + ray * far;
            let place = map_place(view, point);
            let texel = vec2<u32>(clamp(place, vec2(0.0), view.size - 1.0));
            let depth = textureLoad(opaques, view.origin + texel, view.layer, 0).r;
            // Past the edge of a nearer surface, the ray goes on behind it.
            let is_surface = behind_opaque(view, point) < NEAR_SURFACE * texel_at(view, point);
            if is_surface && depth < 1.0 {
                return Landed(is_on_map(view, place), place);
            }
        }
        before = is_behind;
    }
    return nowhere;
}

// Place where a ray through `texel` lands, by the face `number` through which it enters.
fn landing(view: GpuView, texel: vec2<f32>, number: u32) -> Landed {
    let nowhere = Landed(false, vec2(0.0));
    let entry = glass_face(view, number);
    let ray = light_ray(view, texel);
    let met = meets_face(entry, ray);
    let straight = normalize(ray.step);
    let inside = bent(straight, glass_normal(view, number, entry, met.weights, straight), 1.0 / entry.ior);
    if !met.is_met || !inside.passes {
        return nowhere;
    }
    let start = ray.start + ray.step * met.along;
    let left = way_out(view, start, inside.ray);
    if !left.is_there {
        return meets_opaque(view, start, inside.ray);
    }
    let exit = glass_face(view, left.face);
    let out = meets_face(exit, light_ray(view, map_place(view, left.point)));
    let outside = bent(inside.ray, glass_normal(view, left.face, exit, out.weights, inside.ray), exit.ior);
    if !out.is_met || !outside.passes {
        return nowhere;
    }
    return meets_opaque(view, left.point, outside.ray);
}

override WORKGROUP_SIZE: u32;

// Adds to a texel; a sum past 32 bits carries, so that the result does not depend on the order.
fn add_caustic(view: GpuView, place: vec2<f32>, light: vec3<f32>) {
    let texel = vec2<u32>(clamp(place, vec2(0.0), view.size - 1.0));
    let first = 4u * (caustic_params.first + texel.y * u32(view.size.x) + texel.x);
    let added = vec3<u32>(light * CAUSTIC_ONE + 0.5);
    for (var i = 0u; i < 3u; i += 1u) {
        let former = atomicAdd(&caustics[first + i], added[i]);
        if added[i] > ~former {
            atomicAdd(&caustics[first + 3u], 1u << (CARRY_BITS * i));
        }
    }
}

// caustics, throw: adds the light of a map's texels to the texels where glass throws it. One invocation per
// texel.
@compute @workgroup_size(WORKGROUP_SIZE)
fn throw_light(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let index = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    let view = views[0];
    let width = u32(view.size.x);
    if index >= width * u32(view.size.y) {
        return;
    }
    let owner = glass_owners[2u * index];
    if owner == 0u {
        return;
    }
    atomicOr(&caustics[4u * (caustic_params.first + index) + 3u], THROWN_BIT);
    let texel = vec2(index % width, index / width);
    let rays = caustic_params.rays;
    let count = select(0u, rays * rays, owner != 0u);
    let light = textureLoad(filters, view.origin + texel, view.layer, 0).rgb / f32(rays * rays);
    for (var i = 0u; i < count; i += 1u) {
        let part = vec2(f32(i % rays), f32(i / rays)) + 0.5;
        let landed = landing(view, vec2<f32>(texel) + part / f32(rays), ~owner);
        if landed.is_there {
            let corner = floor(landed.at - 0.5);
            let far = landed.at - 0.5 - corner;
            let near = 1.0 - far;
            add_caustic(view, corner, light * (near.x * near.y));
            add_caustic(view, corner + vec2(1.0, 0.0), light * (far.x * near.y));
            add_caustic(view, corner + vec2(0.0, 1.0), light * (near.x * far.y));
            add_caustic(view, corner + vec2(1.0, 1.0), light * (far.x * far.y));
        }
    }
}
