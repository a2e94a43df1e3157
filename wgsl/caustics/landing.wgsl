// Place where a ray that glass refracts lands. CPU reference: crates/gobo-reference/src/caustics.rs.

import package::bind::read::{glass_depths, glass_owners};
import package::bind::uniform::views;
import package::caustics::glass_face::{
    LightRay, glass_face, glass_normal, light_ray, meets_face, weights_at,
};
import package::caustics::light_views::{
    Seen, is_cube, opaque_along, opaque_depth, seen, seen_in, texel_at, texel_number,
};
import package::records::glass::NEAR_SURFACE;

// Doublings of the distance inside a body until the ray is out of it.
const DOUBLINGS: u32 = 16u;
// Halvings that find a crossing.
const HALVINGS: u32 = 14u;
// Steps from glass to the far plane.
const LANDING_STEPS: u32 = 64u;
// Faces that are tried at the place where a ray leaves a body.
const EXITS: u32 = 2u;

struct Landed {
    is_there: bool,
    number: u32,   // of the view
    at: vec2<f32>, // in its map [texels]
}

struct Left {
    is_there: bool,
    point: vec3<f32>,
    face: u32,
    weights: vec3<f32>,
}

struct Bent {
    passes: bool,
    ray: vec3<f32>,
}

// Snell's law for unit vectors; `ratio` of the refractive indices, `normal` on the ray's side. Nothing passes
// at total reflection.
fn bent(ray: vec3<f32>, normal: vec3<f32>, ratio: f32) -> Bent {
    let cosine = -dot(ray, normal);
    let rest = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    let through = ray * ratio + normal * (ratio * cosine - sqrt(max(rest, 0.0)));
    return Bent(rest >= 0.0, normalize(through));
}

// The nearest face by which light leaves a body at a place, as stored; 0 for none.
fn leaving(at: Seen) -> u32 {
    let owner = glass_owners[2u * texel_number(at.number, at.place) + 1u];
    return select(0u, owner, at.is_on_map);
}

// Depth of the nearest face by which light leaves a body at a point's texel, minus the point's depth; below 0
// outside all bodies.
fn left_depth(point: vec3<f32>) -> f32 {
    let at = seen(point);
    let view = views[at.number];
    let depth = bitcast<f32>(~glass_depths[2u * texel_number(at.number, at.place) + 1u]);
    let own = (-at.point.z - view.near) / (view.far - view.near);
    return select(-1.0, depth - own, leaving(at) != 0u);
}

// Point where a ray inside a body leaves it, and the face; `is_there` is false for a surface without a body
// behind it.
fn way_out(start: vec3<f32>, ray: vec3<f32>) -> Left {
    let begin = seen(start);
    if leaving(begin) == 0u {
        return Left(false, start, 0u, vec3(0.0));
    }
    let edge = texel_at(views[begin.number], begin.point);
    var near = 0.0;
    var far = edge;
    for (var i = 0u; i < DOUBLINGS; i += 1u) {
        if left_depth(start + ray * far) < 0.0 {
            break;
        }
        near = far;
        far *= 2.0;
    }
    for (var i = 0u; i < HALVINGS; i += 1u) {
        let middle = 0.5 * (near + far);
        let is_out = left_depth(start + ray * middle) < 0.0;
        near = select(middle, near, is_out);
        far = select(far, middle, is_out);
    }
    // Depths are those of whole texels; the face's plane is exact.
    var left = Left(false, start + ray * near, 0u, vec3(0.0));
    for (var i = 0u; i < EXITS; i += 1u) {
        let owner = leaving(seen(left.point));
        if owner != 0u {
            let face = glass_face(~owner);
            let met = meets_face(face, LightRay(start, ray));
            let is_near = met.is_met && abs(met.along - near) < max(4.0 * edge, 0.5 * near);
            let point = start + ray * select(near, met.along, is_near);
            left = Left(met.is_met, point, ~owner, weights_at(face, point));
        }
    }
    return left;
}

// Depth of a point minus that of the opaque surface at its texel [m].
fn behind_opaque(at: Seen) -> f32 {
    return -at.point.z - opaque_along(at.number, at.place);
}

fn lesser(a: f32, b: f32) -> f32 {
    return select(b, a, abs(a) < abs(b));
}

// Where the ray to a point on a surface, as deep as its texel, meets the plane through the surface's depths
// around it.
fn on_plane(point: vec3<f32>, ray: vec3<f32>) -> Seen {
    let at = seen(point);
    let view = views[at.number];
    let middle = floor(at.place) + 0.5;
    let depth = opaque_along(at.number, middle);
    let left = depth - opaque_along(at.number, middle - vec2(1.0, 0.0));
    let right = opaque_along(at.number, middle + vec2(1.0, 0.0)) - depth;
    let above = depth - opaque_along(at.number, middle - vec2(0.0, 1.0));
    let below = opaque_along(at.number, middle + vec2(0.0, 1.0)) - depth;
    let slope = vec2(lesser(left, right), lesser(above, below));
    let edge = texel_at(view, at.point);
    let before = seen_in(at.number, point - ray * edge);
    let past = -at.point.z - depth - dot(slope, at.place - middle);
    let short = -before.point.z - depth - dot(slope, before.place - middle);
    let steps = clamp(past / max(past - short, 0.05 * edge), -2.0, 2.0);
    return seen(point - ray * (steps * edge));
}

// Length of a ray's way to the far plane, or to the first of a cube's far planes.
fn way_to_end(start: vec3<f32>, ray: vec3<f32>) -> f32 {
    let faces = select(vec3(1u, 3u, 5u), vec3(0u, 2u, 4u), ray > vec3(0.0));
    let far = vec3(views[faces.x].far, views[faces.y].far, views[faces.z].far);
    let ends = (far - start * sign(ray)) / max(abs(ray), vec3(1e-12));
    let single = (views[0].far + start.z) / -min(ray.z, -1e-12);
    return select(single, min(min(ends.x, ends.y), ends.z), is_cube());
}

// First place where a ray meets the opaque depths.
fn meets_opaque(start: vec3<f32>, ray: vec3<f32>) -> Landed {
    let nowhere = Landed(false, 0u, vec2(0.0));
    if (!is_cube()) & (ray.z >= 0.0) {
        return nowhere;
    }
    let step = way_to_end(start, ray) / f32(LANDING_STEPS);
    var before = false;
    for (var i = 0u; i <= LANDING_STEPS; i += 1u) {
        let along = step * f32(i);
        let here = seen(start + ray * along);
        if !here.is_on_map {
            return nowhere;
        }
        let is_behind = behind_opaque(here) >= 0.0;
        if is_behind && !before {
            var near = max(along - step, 0.0);
            var far = along;
            for (var k = 0u; k < HALVINGS; k += 1u) {
                let middle = 0.5 * (near + far);
                let is_past = behind_opaque(seen(start + ray * middle)) >= 0.0;
                near = select(middle, near, is_past);
                far = select(far, middle, is_past);
            }
            let point = start + ray * far;
            let at = seen(point);
            let view = views[at.number];
            // Past the edge of a nearer surface, the ray goes on behind it.
            let is_surface = behind_opaque(at) < NEAR_SURFACE * texel_at(view, at.point);
            if is_surface && opaque_depth(at.number, at.place) < 1.0 {
                let met = on_plane(point, ray);
                return Landed(met.is_on_map, met.number, met.place);
            }
        }
        before = is_behind;
    }
    return nowhere;
}

// Place where a ray through `texel` of the view `number` lands, by the face `owner` through which it enters.
// `shift`: -1 for red light, 1 for blue.
fn landing(number: u32, texel: vec2<f32>, owner: u32, shift: f32) -> Landed {
    let nowhere = Landed(false, 0u, vec2(0.0));
    let entry = glass_face(owner);
    let ray = light_ray(number, texel);
    let met = meets_face(entry, ray);
    let straight = normalize(ray.step);
    let ratio = 1.0 / (entry.ior + shift * entry.spread);
    let inside = bent(straight, glass_normal(owner, entry, met.weights, straight), ratio);
    if !met.is_met || !inside.passes {
        return nowhere;
    }
    let left = way_out(ray.start + ray.step * met.along, inside.ray);
    var outside = inside;
    if left.is_there {
        let exit = glass_face(left.face);
        let normal = glass_normal(left.face, exit, left.weights, inside.ray);
        outside = bent(inside.ray, normal, exit.ior + shift * exit.spread);
        if !outside.passes {
            return nowhere;
        }
    }
    // One call: it is most of the kernel.
    return meets_opaque(left.point, outside.ray);
}
