// accumulate, curve segments: the curves of one segment of a long tile. One workgroup per segment,
// a column of texels per invocation. resolve_curve puts a tile's segments together in order. CPU
// twin: src/reference/curve/tile.rs. Host: src/stage/curve.rs.

import package::bind::changed::{counters, partials};
import package::bind::read::{dispatches, segments};
import package::bind::uniform::views;
import package::curve::gather::{light_texel, nearest, scale, start, total_light};
import package::curve::list::disordered;
import package::curve::partial::{first_node, partial_size};
import package::curve::stored::{packed_pair, packed_row};
import package::curve::volumes::{crossed, density, last_face, surface_scale, surface_light};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES};
import package::records::dispatch::SEGMENT_DISPATCH;
import package::records::view::{GpuView, TILE_SIZE};
import package::walk::lane::{LANES, lane_texel, sum_index, tile_texel};
import choice::rows::ROWS;
import choice::walk::walk;

fn open_rest(view: GpuView, step: u32) {}

@compute @workgroup_size(LANES)
fn accumulate_curve_segments(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup.y * workgroups.x + workgroup.x;
    if index >= dispatches[SEGMENT_DISPATCH].w {
        return;
    }
    let segment = segments[index];
    let view = views[segment.view];
    let place = lane_texel(lane);
    start(view, tile_texel(view, segment.tile) + place);
    walk(view, segment.first, segment.end);
    let at = sum_index(index, place) * partial_size();
    let all = total_light();
    for (var i = 0u; i < ROWS; i += 1u) {
        let whole = bitcast<vec4<u32>>(vec4(light_texel(all, i), nearest[i]));
        partials[at + i * TILE_SIZE * partial_size()] = whole;
    }
    if HAS_OVER || HAS_VOLUMES {
        store_change(at, 0u);
        store_change(at, 1u);
        store_change(at, 2u);
        store_change(at, 3u);
    }
    store_pair(at, 0u);
    store_pair(at, 1u);
    if NODES > 4u {
        store_pair(at, 2u);
        store_pair(at, 3u);
    }
    if NODES > 8u {
        store_pair(at, 4u);
        store_pair(at, 5u);
        store_pair(at, 6u);
        store_pair(at, 7u);
    }
    if disordered > 0u {
        atomicAdd(&counters.disordered, disordered);
    }
}

fn store_change(first: u32, i: u32) {
    let at = first + i * TILE_SIZE * partial_size() + 1u;
    partials[at] = bitcast<vec4<u32>>(vec4(light_texel(scale, i), 0.0));
    partials[at + 1u] = bitcast<vec4<u32>>(vec4(light_texel(surface_scale, i), last_face[i]));
    partials[at + 2u] = bitcast<vec4<u32>>(vec4(light_texel(surface_light, i), 0.0));
    partials[at + 3u] = bitcast<vec4<u32>>(vec4(light_texel(density, i), 0.0));
    partials[at + 4u] = bitcast<vec4<u32>>(crossed[i]);
}

fn store_pair(at: u32, pair: u32) {
    let nodes = packed_pair(pair);
    let row = TILE_SIZE * partial_size();
    partials[at + first_node() + pair] = packed_row(nodes, 0u);
    partials[at + row + first_node() + pair] = packed_row(nodes, 1u);
    partials[at + 2u * row + first_node() + pair] = packed_row(nodes, 2u);
    partials[at + 3u * row + first_node() + pair] = packed_row(nodes, 3u);
}
