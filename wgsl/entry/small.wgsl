// Casters of few texels, without pairs. CPU reference: crates/gobo-reference/src/occlude.rs,
// crates/gobo-reference/src/accumulate.rs. Rust: src/stage/occlude.rs, src/stage/accumulate.rs.

import package::bind::changed::{counters, small_depths};
import package::bind::loaded::triangles;
import package::bind::read::chunks;
import package::bind::uniform::{project_params, views};
import package::features::unrolled;
import package::hit::triangle::{edge_line, edge_products, is_inside, owns_edge};
import package::records::batch::{Chunk, workgroup_number};
import package::records::footprint::load_footprint;
import package::records::record::{TRIANGLE_TEXELS, record_texel};
import package::records::texel::opaque_bits;
import package::records::tile::{is_scattered, scatter_texel};
import package::records::view::TILE_SIZE;
import package::sums::scatter::scatter;
import choice::records::rect_record;

override WORKGROUP_SIZE: u32;
const SPAN_SLACK: f32 = 0.015625; // [texels]; the edge functions decide

var<private> edges: array<vec4<f32>, 3>;
var<private> slopes: vec3<f32>; // of the edges: texels along x per texel along y

// First and last column of the texels of row `y` that may be inside.
fn row_span(y: f32, lo: f32, hi: f32) -> vec2<f32> {
    var span = vec2(lo, hi);
    for (var i = 0u; i < unrolled(3u); i += 1u) {
        let edge = edges[i];
        let x = edge.x + (y + 0.5 - edge.y) * slopes[i];
        span.x = select(span.x, max(span.x, x), edge.w < 0.0);
        span.y = select(span.y, min(span.y, x), edge.w > 0.0);
    }
    return vec2(ceil(span.x - (0.5 + SPAN_SLACK)), floor(span.y - (0.5 - SPAN_SLACK)));
}

// occlude, small: opaque triangles of a few texels, written straight to these texels' depths, without
// footprints, sort and bin. One invocation per triangle and view; a workgroup takes a chunk, whose triangles
// the CPU knows to be small and beyond the near plane.
@compute @workgroup_size(WORKGROUP_SIZE)
fn occlude_small(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let chunk_index = workgroup_number(workgroup, workgroups);
    if chunk_index >= project_params.chunk_count {
        return;
    }
    let chunk = chunks[chunk_index];
    let view = views[chunk.view];
    let first = (chunk.first_caster + min(lane, chunk.count - 1u)) * TRIANGLE_TEXELS;
    var p: array<vec2<f32>, 3>;
    var distances: vec3<f32>;
    for (var i = 0u; i < unrolled(3u); i += 1u) {
        let corner = bitcast<vec4<f32>>(textureLoad(triangles, record_texel(first + i)));
        let at = view.view_from_world * vec4(corner.xyz, 1.0);
        distances[i] = -at.z;
        p[i] = vec2(at.x, -at.y) * view.scale;
    }
    let weights = select(vec3(1.0), 1.0 / distances, view.perspective > 0.0);
    let half_size = view.size * 0.5;
    for (var i = 0u; i < unrolled(3u); i += 1u) {
        p[i] = p[i] * weights[i] + half_size;
    }
    let ab = p[1] - p[0];
    let ac = p[2] - p[0];
    let area = ab.x * ac.y - ab.y * ac.x;
    let owned = vec3(
        owns_edge(p[1], p[2], area),
        owns_edge(p[2], p[0], area),
        owns_edge(p[0], p[1], area),
    );
    edges[0] = edge_line(p[1], p[2], area);
    edges[1] = edge_line(p[2], p[0], area);
    edges[2] = edge_line(p[0], p[1], area);
    let across = vec3(edges[0].w, edges[1].w, edges[2].w);
    let along = vec3(edges[0].z, edges[1].z, edges[2].z);
    slopes = select(along / across, vec3(0.0), across == vec3(0.0));
    let lo = max(min(p[0], min(p[1], p[2])), vec2(0.0));
    let hi = min(max(p[0], max(p[1], p[2])), view.size);
    let depths = (distances - view.near) / (view.far - view.near);
    let first_texel = view.first_tile * TILE_SIZE * TILE_SIZE;
    let row_texels = view.tiles_x * TILE_SIZE;

    var y = ceil(lo.y - 0.5);
    // Written so that a NaN is outside.
    let here = lane < chunk.count && area != 0.0 && lo.x <= hi.x && lo.y <= hi.y;
    let last_y = select(-1.0, floor(hi.y - 0.5), here);
    var span = row_span(y, lo.x, hi.x);
    var x = span.x;
    while y <= last_y {
        let a = edge_products(edges[0], vec2(x, y) + 0.5);
        let b = edge_products(edges[1], vec2(x, y) + 0.5);
        let c = edge_products(edges[2], vec2(x, y) + 0.5);
        let e = vec3(a.x - a.y, b.x - b.y, c.x - c.y);
        let weighted = e * weights;
        let depth = dot(weighted, depths) / (weighted.x + weighted.y + weighted.z);
        let inside = is_inside(a, b, c, owned) && x <= span.y;
        if inside && depth >= 0.0 && depth <= 1.0 {
            let texel = first_texel + u32(y) * row_texels + u32(x);
            atomicMin(&small_depths[texel], opaque_bits(depth, false));
        }
        x += 1.0;
        let next = x > span.y;
        y = select(y, y + 1.0, next);
        span = row_span(y, lo.x, hi.x);
        x = select(x, span.x, next);
    }
}

// accumulate, tiny: particles of at most 2x2 texels, added straight to the sums. One invocation per
// footprint; workgroups stride over the chunks, so few that the invocations in flight on one texel cannot
// wrap its sum.
@compute @workgroup_size(WORKGROUP_SIZE)
fn accumulate_tiny(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    var scattered = 0u;
    for (var i = workgroup.x; i < project_params.chunk_count; i += workgroups.x) {
        scattered += scatter_particle(chunks[i], lane);
    }
    if scattered > 0u {
        atomicAdd(&counters.scattered, scattered);
    }
}

// Number of particles that were scattered: one or none.
fn scatter_particle(chunk: Chunk, lane: u32) -> u32 {
    let index = chunk.first_footprint + lane;
    let rect = rect_record(index);
    if lane >= chunk.count || !is_scattered(rect) {
        return 0u;
    }
    let view = views[chunk.view];
    let footprint = load_footprint(index);
    let first = vec2<i32>(scatter_texel(footprint.bounds.xy));
    for (var i = 0; i < 4; i += 1) {
        let texel = first + vec2(i & 1, i >> 1u);
        if all(texel >= vec2(0)) && all(texel < vec2<i32>(view.size)) {
            scatter(view, footprint, vec2<u32>(texel));
        }
    }
    return 1u;
}
