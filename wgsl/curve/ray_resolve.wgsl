// Output: curves, filter and nearest depth of tiles with several segments, whose nodes are taken as hits. CPU
// reference: crates/gobo-reference/src/curve/tile.rs, `resolved`.

import package::bind::read::partials;
import package::bind::stored::{curves, filters, nearests};
import package::curve::blank::stays_blank;
import package::curve::node::{
    DEPTHS, curve_segment, node_length, node_of_pair, node_passed, node_start,
};
import package::curve::pages::{page_of, place_in};
import package::curve::ray::{RayHit, TRACE, begin_second, found, start, texels, visit_hit};
import package::curve::ray_nodes::{end_walk, visit_scattered};
import package::curve::stored::{first_node, partial_size};
import package::features::{NODES, unrolled};
import package::records::tile::Tile;
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::{blackened, light, nearness_to_depth};
import package::traversal::lane::sum_index;
import choice::accumulator::ROWS;
import choice::sums::{clear_sums, load_nearness, load_sums};

const SPLITS: bool = false;

// No tile of several segments is without a caster.
fn is_blank() -> bool {
    return false;
}

struct Scattered {
    light: vec3<f32>,
    depth: f32,
}

var<private> walked_tile: u32;
var<private> walked_page: u32;

fn scattered() -> bool {
    return true;
}

fn scattered_light(corner: vec2<f32>, i: u32) -> Scattered {
    let sum = sum_index(walked_tile, vec2<u32>(corner) % TILE_SIZE) + i * TILE_SIZE;
    return Scattered(light(load_sums(sum)), nearness_to_depth(load_nearness(sum)));
}

fn store_nodes(view: GpuView, corner: vec2<f32>, i: u32, pair: u32, nodes: vec4<u32>) {
    let at = view.origin + vec2<u32>(corner) + vec2(0u, i);
    let place = place_in(walked_page, at, view.layer);
    textureStore(curves, place.xy, place.z + pair, nodes);
}

// Light behind all segments, and their nearest depth.
fn whole_of(first: u32, count: u32, in_tile: vec2<u32>) -> vec4<f32> {
    var whole = vec4(1.0);
    for (var k = 0u; k < count; k += 1u) {
        let found = bitcast<vec4<f32>>(partials[sum_index(first + k, in_tile) * partial_size()]);
        whole = vec4(whole.rgb * found.rgb, min(whole.a, found.a));
    }
    return whole;
}

fn visit_nodes(view: GpuView, first: u32, count: u32, in_tile: vec2<u32>) {
    for (var n = 0u; n < count * NODES; n += 1u) {
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            let at = sum_index(first + n / NODES, in_tile + vec2(0u, i)) * partial_size() + first_node();
            let node = node_of_pair(partials[at + n % NODES / 2u], n);
            let begin = node_start(node) / DEPTHS;
            let end = (node_start(node) + node_length(node)) / DEPTHS;
            let presence = select(0.0, TRACE, begin > 0.0);
            var texel = texels[i];
            visit_hit(view, &texel, i, RayHit(1.0 - node_passed(node), begin, begin, end, presence));
            texels[i] = texel;
        }
    }
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    let count = (tile.end - tile.first + curve_segment() - 1u) / curve_segment();
    let first = tile.merged - 1u;
    walked_tile = tile_id;
    walked_page = page_of(view.origin + tile.position * TILE_SIZE, view.layer);
    let blank = stays_blank(view, tile.position * TILE_SIZE, true);
    start(view, tile.position * TILE_SIZE + in_tile);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i].nearest = whole_of(first, count, in_tile + vec2(0u, i)).a;
    }
    visit_nodes(view, first, count, in_tile);
    visit_scattered(view);
    begin_second();
    visit_nodes(view, first, count, in_tile);
    visit_scattered(view);
    end_walk(view);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let below = vec2(0u, i);
        let at = view.origin + tile.position * TILE_SIZE + in_tile + below;
        let sum = sum_index(tile_id, in_tile + below);
        let all = whole_of(first, count, in_tile + below).rgb * light(load_sums(sum));
        textureStore(filters, at, view.layer, vec4(blackened(min(all, vec3(65504.0))), 1.0));
        textureStore(nearests, at, view.layer, vec4(found[i].a));
        clear_sums(sum);
    }
}
