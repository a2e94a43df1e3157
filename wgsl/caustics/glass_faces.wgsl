// caustics, faces: the nearest face of glass in each texel of a view's map by which light enters a body, and
// the nearest by which it leaves one; or the nearest solid face of either side. First their depths, then the
// indices of the faces with these depths. The workgroups of a face take turns with its texels. CPU reference:
// crates/gobo-reference/src/caustics.rs. Rust: src/stage/caustics.rs.

import package::bind::changed::{glass_depths, glass_owners};
import package::bind::sampled::opaques;
import package::bind::uniform::{caustic_params, views};
import package::caustics::glass_face::{
    GlassFace, LEAST_WEIGHT, glass_face, light_ray, meets_face,
};
import package::caustics::light_views::{in_view, map_place};
import package::records::view::GpuView;

override WORKGROUP_SIZE: u32;
override FINDS_OWNERS: bool;
// Faces are solid: the map of opaque depths, which they may be in, does not hide them.
override ARE_SOLID: bool;

// Distance in front of a lamp from which faces have a place in its map [m].
const AHEAD: f32 = 0.0001;

// Least and largest place of a face in the map [texels].
struct Extent {
    least: vec2<f32>,
    last: vec2<f32>,
}

fn extended(extent: Extent, view: GpuView, point: vec3<f32>) -> Extent {
    let place = map_place(view, point);
    return Extent(min(extent.least, place), max(extent.last, place));
}

// An extent with a corner in view space, and with the end of its edge to the next where that reaches behind
// the lamp.
fn with_corner(extent: Extent, view: GpuView, corner: vec3<f32>, next: vec3<f32>) -> Extent {
    let end = select(3e38, -AHEAD, view.perspective > 0.0);
    let is_ahead = corner.z <= end;
    var wide = extent;
    if is_ahead {
        wide = extended(extent, view, corner);
    }
    if is_ahead != (next.z <= end) {
        wide = extended(wide, view, mix(corner, next, (end - corner.z) / (next.z - corner.z)));
    }
    return wide;
}

fn face_extent(view: GpuView, face: GlassFace) -> Extent {
    let a = in_view(0u, face.corners[0]);
    let b = in_view(0u, face.corners[1]);
    let c = in_view(0u, face.corners[2]);
    let extent = with_corner(Extent(view.size, vec2(0.0)), view, a, b);
    return with_corner(with_corner(extent, view, b, c), view, c, a);
}

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
    let face = glass_face(number);
    let extent = face_extent(view, face);
    let least = vec2<u32>(clamp(floor(extent.least), vec2(0.0), view.size));
    let last = vec2<u32>(clamp(ceil(extent.last), vec2(0.0), view.size));
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
        let ray = light_ray(0u, vec2<f32>(texel) + 0.5);
        let met = meets_face(face, ray);
        let depth = (met.along - view.near) / (view.far - view.near);
        let leaves = !ARE_SOLID && dot(face.normal, ray.step) > 0.0;
        var end = 1.0;
        if !ARE_SOLID {
            end = textureLoad(opaques, view.origin + texel, view.layer, 0).r;
        }
        let inside = min(min(met.weights.x, met.weights.y), met.weights.z) >= LEAST_WEIGHT;
        if met.is_met && inside && depth >= 0.0 && depth < end {
            let at = 2u * (caustic_params.base + texel.y * width + texel.x) + select(0u, 1u, leaves);
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
