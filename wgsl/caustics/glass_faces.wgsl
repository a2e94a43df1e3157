// caustics, faces: the nearest face of glass in each texel of a view's map by which light enters a body, and
// the nearest by which it leaves one; or the nearest solid face of either side. First their depths, then the
// indices of the faces with these depths. One invocation per small face; the lanes of one or several
// workgroups take turns with the texels of a large one. CPU reference: crates/gobo-reference/src/caustics.rs.

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

// Workgroup size.
const FACE_LANES: u32 = 64u;
// Most texels of a face that one lane searches.
const MOST_ALONE: u32 = 32u;

// Faces with more texels.
var<workgroup> large_count: atomic<u32>;
var<workgroup> large: array<u32, FACE_LANES>;

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

// Texels of a face in the map: the first, and their number along x and y.
struct Box {
    least: vec2<u32>,
    size: vec2<u32>,
}

fn box_of(face: GlassFace) -> Box {
    let view = views[0];
    let extent = face_extent(view, face);
    let least = vec2<u32>(clamp(floor(extent.least), vec2(0.0), view.size));
    let last = vec2<u32>(clamp(ceil(extent.last), vec2(0.0), view.size));
    return Box(least, max(last, least) - least);
}

fn find_in_texel(number: u32, face: GlassFace, texel: vec2<u32>) {
    let view = views[0];
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
        let width = u32(view.size.x);
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

// Every so many of the texels of a box, from `first` on.
fn find_in_box(number: u32, face: GlassFace, box: Box, first: u32, every: u32) {
    for (var i = first; i < box.size.x * box.size.y; i += every) {
        find_in_texel(number, face, box.least + vec2(i % box.size.x, i / box.size.x));
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn glass_faces(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let start = (workgroup.y * workgroups.x + workgroup.x) * WORKGROUP_SIZE;
    if lane == 0u {
        atomicStore(&large_count, 0u);
    }
    workgroupBarrier();
    // Each lane has a small face of its own; large ones are shared by all.
    let own = start + lane;
    if own < caustic_params.face_count {
        let face = glass_face(own);
        let box = box_of(face);
        if box.size.x * box.size.y > MOST_ALONE {
            large[atomicAdd(&large_count, 1u)] = own;
        } else if workgroup.z == 0u {
            find_in_box(own, face, box, 0u, 1u);
        }
    }
    workgroupBarrier();
    let count = atomicLoad(&large_count);
    for (var i = 0u; i < count; i += 1u) {
        let number = large[i];
        let face = glass_face(number);
        let first = workgroup.z * WORKGROUP_SIZE + lane;
        find_in_box(number, face, box_of(face), first, caustic_params.slices * WORKGROUP_SIZE);
    }
}
