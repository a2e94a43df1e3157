// Output: the curves of one segment of a long tile; `resolve` combines a tile's segments in order. CPU reference:
// src/reference/curve/tile.rs.

import package::bind::changed::{counters, partials};
import package::curve::gather::{ROWS, light_texel, nearest, scale, total_light};
import package::curve::list::disordered;
import package::curve::partial::{first_node, partial_size};
import package::curve::stored::{packed_pair, packed_row};
import package::curve::volumes::{crossed, density, last_face, surface_light, surface_scale};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES};
import package::records::tile::Segment;
import package::records::view::{GpuView, TILE_SIZE};
import package::traversal::lane::sum_index;

fn open_rest(view: GpuView, step: u32) {}

fn store_segment(segment: Segment, index: u32, place: vec2<u32>) {
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
    leave_pair(at, 0u);
    leave_pair(at, 1u);
    if NODES > 4u {
        leave_pair(at, 2u);
        leave_pair(at, 3u);
    }
    if NODES > 8u {
        leave_pair(at, 4u);
        leave_pair(at, 5u);
        leave_pair(at, 6u);
        leave_pair(at, 7u);
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

fn leave_pair(at: u32, pair: u32) {
    let nodes = packed_pair(pair);
    let row = TILE_SIZE * partial_size();
    partials[at + first_node() + pair] = packed_row(nodes, 0u);
    partials[at + row + first_node() + pair] = packed_row(nodes, 1u);
    partials[at + 2u * row + first_node() + pair] = packed_row(nodes, 2u);
    partials[at + 3u * row + first_node() + pair] = packed_row(nodes, 3u);
}
