// Output: the curves of discs in one segment of a long tile; `resolve` combines a tile's segments in order.

import package::bind::changed::partials;
import package::curve::stored::{first_node, partial_size};
import package::features::unrolled;
import package::records::tile::Segment;
import package::records::view::{GpuView, TILE_SIZE};
import package::traversal::lane::sum_index;
import choice::accumulator::{ROWS, found};

const SPLITS: bool = false; // `resolve` joins nodes

var<private> walked_segment: u32;

fn before_segment(index: u32) {
    walked_segment = index;
}

// No tile of several segments is without a caster.
fn is_blank() -> bool {
    return false;
}

// Whether some casters have no pairs: `resolve` adds those of the tile.
fn scattered() -> bool {
    return false;
}

struct Scattered {
    light: vec3<f32>,
    depth: f32,
}

fn scattered_light(corner: vec2<f32>, i: u32) -> Scattered {
    return Scattered(vec3(1.0), 1.0);
}

fn partial_at(corner: vec2<f32>, i: u32) -> u32 {
    return (sum_index(walked_segment, vec2<u32>(corner) % TILE_SIZE) + i * TILE_SIZE) * partial_size();
}

// Stores nodes 2 `pair` and 2 `pair` + 1.
fn store_nodes(view: GpuView, corner: vec2<f32>, i: u32, pair: u32, nodes: vec4<u32>) {
    partials[partial_at(corner, i) + first_node() + pair] = nodes;
}

fn store_nodes_where(view: GpuView, corner: vec2<f32>, i: u32, pair: u32, nodes: vec4<u32>, is: bool) {
    if is {
        store_nodes(view, corner, i, pair, nodes);
    }
}

fn store_segment(segment: Segment, index: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        partials[partial_at(vec2<f32>(in_tile), i)] = bitcast<vec4<u32>>(found[i]);
    }
}
