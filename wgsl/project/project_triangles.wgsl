// project: triangles -> footprints, depth keys, tile rectangles and setups. One invocation per
// triangle and view; a workgroup takes a chunk. CPU reference: crates/gobo-reference/src/project.rs. Rust:
// src/stage/project.rs.

import package::bind::read::chunks;
import package::bind::sampled::triangles;
import package::bind::uniform::{project_params, views};
import package::features::HAS_VERTEX_COLORS;
import package::hit::triangle::{edge_line, edge_plane, owns_edge};
import package::project::extent::put;
import package::records::batch::workgroup_number;
import package::records::footprint::{BACK_BIT, SETUP_TEXELS};
import package::records::pack::octahedral;
import package::records::record::{FootprintRecord, TRIANGLE_BIT, TRIANGLE_TEXELS, record_texel};
import package::records::tile::{INVISIBLE, SLACK, box_rect, depth_key, distance_key};
import package::records::view::MIN_DISTANCE;
import choice::writes::{write_footprint, write_setup_words};

override WORKGROUP_SIZE: u32;

fn put_setup(setup_index: u32, texel: u32, value: vec4<u32>) {
    write_setup_words(setup_index * SETUP_TEXELS + texel, value);
}

// Least distance of a triangle's points from the origin.
fn least_distance(corners: array<vec3<f32>, 3>) -> f32 {
    var points = corners;
    let normal = cross(points[1] - points[0], points[2] - points[0]);
    var least = 1e30;
    var over = true;
    for (var i = 0u; i < 3u; i += 1u) {
        let start = points[i];
        let along = points[(i + 1u) % 3u] - start;
        let part = clamp(-dot(start, along) / max(dot(along, along), MIN_DISTANCE), 0.0, 1.0);
        least = min(least, length(start + along * part));
        over = over && dot(normal, cross(along, -start)) >= 0.0;
    }
    return select(least, abs(dot(normal, points[0])) / max(length(normal), MIN_DISTANCE), over);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn project_triangles(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let chunk_index = workgroup_number(workgroup, workgroups);
    if chunk_index >= project_params.chunk_count {
        return;
    }
    let chunk = chunks[chunk_index];
    if lane >= chunk.count {
        return;
    }
    let index = chunk.first_footprint + lane;
    let triangle_id = chunk.first_caster + lane;
    let setup_index = index - project_params.first_setup;
    let view = views[chunk.view];
    let half_size = view.size * 0.5;

    let first = triangle_id * TRIANGLE_TEXELS;
    var world: array<vec3<f32>, 3>;
    var us: vec3<f32>;
    var flat: array<vec2<f32>, 3>;
    var distances: vec3<f32>;
    var corners: array<vec3<f32>, 3>; // view space
    for (var i = 0u; i < 3u; i += 1u) {
        let corner = bitcast<vec4<f32>>(textureLoad(triangles, record_texel(first + i), 0));
        world[i] = corner.xyz;
        us[i] = corner.w;
        let p = (view.view_from_world * vec4(corner.xyz, 1.0)).xyz;
        corners[i] = p;
        flat[i] = vec2(p.x, -p.y) * view.scale;
        distances[i] = -p.z;
    }
    let v_material = textureLoad(triangles, record_texel(first + 3u), 0);
    let depths = (distances - view.near) / (view.far - view.near);
    let nearest = min(depths.x, min(depths.y, depths.z));
    let farthest = max(depths.x, max(depths.y, depths.z));
    // The back face of a volume also matters beyond the far plane.
    if farthest < 0.0 {
        put(index, INVISIBLE, vec2(0u));
        return;
    }
    let crosses = view.perspective > 0.0 && nearest < 0.0;
    var weights = select(vec3(1.0), 1.0 / distances, view.perspective > 0.0);
    var p: array<vec2<f32>, 3>;
    var h: array<vec3<f32>, 3>; // homogeneous
    for (var i = 0u; i < 3u; i += 1u) {
        p[i] = flat[i] * weights[i] + half_size;
        h[i] = vec3(flat[i] + distances[i] * half_size, distances[i]);
    }
    let ab = p[1] - p[0];
    let ac = p[2] - p[0];
    let turn = select(ab.x * ac.y - ab.y * ac.x, dot(h[0], cross(h[1], h[2])), crosses);
    var edges: array<vec4<f32>, 3>;
    var ties = select(0u, BACK_BIT, turn > 0.0);
    var lo = vec2(1e30);
    var hi = vec2(-1e30);
    for (var i = 0u; i < 3u; i += 1u) {
        let j = (i + 1u) % 3u;
        let k = (i + 2u) % 3u;
        // A corner behind the near plane has no position in the map.
        let is_front = !crosses || distances[i] >= view.near;
        lo = select(lo, min(lo, p[i]), is_front);
        hi = select(hi, max(hi, p[i]), is_front);
        if crosses {
            // Bounding box of the part beyond the near plane.
            let crossing = clamp((view.near - distances[i]) / (distances[j] - distances[i]), 0.0, 1.0);
            let cut = (flat[i] + (flat[j] - flat[i]) * crossing) / view.near + half_size;
            let cuts = (distances[i] >= view.near) != (distances[j] >= view.near);
            lo = select(lo, min(lo, cut), cuts);
            hi = select(hi, max(hi, cut), cuts);
        }
        if !crosses || (distances[j] >= view.near && distances[k] >= view.near) {
            edges[i] = edge_line(p[j], p[k], turn);
            ties |= select(0u, 1u << i, owns_edge(p[j], p[k], turn));
            weights[i] = select(weights[i], distances[j] * distances[k], crosses);
        } else {
            edges[i] = edge_plane(h[j], h[k], turn);
            ties |= select(0u, 1u << i, owns_edge(h[j].xy, h[k].xy, turn));
            weights[i] = 1.0;
        }
    }
    lo = clamp(lo, vec2(-1.0), view.size + 1.0);
    hi = clamp(hi, vec2(-1.0), view.size + 1.0);
    let center = (lo + hi) * 0.5;
    let rect = box_rect(view.size, chunk.view, lo, hi);
    if turn == 0.0 || rect.y == 0u {
        put(index, INVISIBLE, vec2(0u));
        return;
    }
    let least = distance_key(view, least_distance(corners));
    let by_distance = (project_params.by_distance == 1u) & (view.perspective > 0.0);
    let front = depth_key(select(max(nearest, 0.0), least, by_distance));
    put(index, front, rect);
    let radius = max(hi.x - lo.x, hi.y - lo.y) * 0.5 + SLACK;
    let bounds = vec4(center, radius, max(nearest, 0.0));
    let look = vec4(setup_index, 0u, front << 16u, triangle_id | TRIANGLE_BIT);
    write_footprint(index, FootprintRecord(bounds, look));
    for (var i = 0u; i < 3u; i += 1u) {
        put_setup(setup_index, i, bitcast<vec4<u32>>(edges[i]));
    }
    let v = bitcast<vec3<f32>>(v_material.xyz);
    let id = textureLoad(triangles, record_texel(first + 4u), 0).w;
    let normal = cross(world[1] - world[0], world[2] - world[0]);
    let unit = normal / max(length(normal), 1e-30);
    put_setup(setup_index, 3u, vec4(bitcast<vec3<u32>>(weights), ties));
    put_setup(setup_index, 4u, vec4(bitcast<vec3<u32>>(depths), v_material.w));
    put_setup(setup_index, 5u, bitcast<vec4<u32>>(vec4(us.x, v.x, us.y, v.y)));
    put_setup(setup_index, 6u, vec4(bitcast<vec2<u32>>(vec2(us.z, v.z)), octahedral(unit), id));
    if HAS_VERTEX_COLORS {
        put_setup(setup_index, 7u, textureLoad(triangles, record_texel(first + 5u), 0));
    }
}
