// caustics, faces: the nearest face of glass in each texel of a view's map by which light enters a body, and
// the nearest by which it leaves one: first their depths, then the indices of the faces with these depths.
// The workgroups of a face take turns with its texels. CPU reference: crates/gobo-reference/src/caustics.rs.
// Rust: src/stage/caustics.rs.

import package::bind::changed::{glass_depths, glass_owners};
import package::bind::sampled::opaques;
import package::bind::uniform::{caustic_params, views};
import package::caustics::glass_face::{
    LEAST_WEIGHT, glass_face, light_ray, map_place, meets_face,
};

override WORKGROUP_SIZE: u32;
override FINDS_OWNERS: bool;

// Distance behind a lamp's position from which a face has no place in its map [m].
const AHEAD: f32 = 0.0001;

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
