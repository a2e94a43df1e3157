// Output: the curves, filter and nearest depth of a tile of discs that one workgroup finishes.

import package::curve::blank::stays_blank;
import package::curve::pages::{page_of, place_in};
import package::features::unrolled;
import package::records::tile::{Tile, tile_number_of};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::{blackened, light, nearness_to_depth};
import package::traversal::lane::sum_index;
import choice::accumulator::{ROWS, found};
import choice::maps::{plain_alpha, store_map, store_pair, store_pair_where};
import choice::sums::{clear_sums, load_nearness, load_sums};

const SPLITS: bool = true; // bodies are split with free nodes

var<private> walked_tile: u32;
var<private> walked_page: u32;
var<private> has_scattered: bool;
var<private> blank: bool;
var<private> alpha_of_none: f32;

fn before_tile(view: GpuView, texel: vec2<u32>, tile: Tile) {
    walked_tile = tile_number_of(view, tile);
    has_scattered = tile.scattered;
    blank = stays_empty(view, texel, tile);
    alpha_of_none = 1.0;
    walked_page = page_of(view.origin + texel, view.layer);
    for (var turn = u32(blank); turn < 1u; turn += 1u) {
        alpha_of_none = plain_alpha(view.origin + texel, view.layer);
    }
}

// Whether the tile's curves are not stored.
fn is_blank() -> bool {
    return blank;
}

// Whether some of the tile's casters have no pairs.
fn scattered() -> bool {
    return has_scattered;
}

// These casters' light at row `i` of a column of texels.
struct Scattered {
    light: vec3<f32>,
    depth: f32, // of the nearest visible caster, 1 for none
}

fn scattered_light(corner: vec2<f32>, i: u32) -> Scattered {
    let sum = sum_index(walked_tile, vec2<u32>(corner) % TILE_SIZE) + i * TILE_SIZE;
    return Scattered(light(load_sums(sum)), nearness_to_depth(load_nearness(sum)));
}

// Stores nodes 2 `pair` and 2 `pair` + 1.
fn store_nodes(view: GpuView, corner: vec2<f32>, i: u32, pair: u32, nodes: vec4<u32>) {
    let at = view.origin + vec2<u32>(corner) + vec2(0u, i);
    let place = place_in(walked_page, at, view.layer);
    store_pair(place.xy, place.z + pair, nodes);
}

fn store_nodes_where(view: GpuView, corner: vec2<f32>, i: u32, pair: u32, nodes: vec4<u32>, is: bool) {
    let at = view.origin + vec2<u32>(corner) + vec2(0u, i);
    let place = place_in(walked_page, at, view.layer);
    store_pair_where(place.xy, place.z + pair, nodes, is);
}

// Whether the tile has no casters, and its curves are not stored.
fn stays_empty(view: GpuView, texel: vec2<u32>, tile: Tile) -> bool {
    return stays_blank(view, texel, (tile.first < tile.end) | tile.scattered);
}

fn store_empty(view: GpuView, texel: vec2<u32>) {
    let alpha = plain_alpha(view.origin + texel, view.layer);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        store_map(view.origin + texel + vec2(0u, i), view.layer, vec4(vec3(1.0), alpha), 1.0);
    }
}

fn store_tile(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = view.origin + texel + vec2(0u, i);
        store_map(at, view.layer, vec4(blackened(found[i].rgb), alpha_of_none), found[i].a);
    }
    for (var turn = 0u; turn < u32(scattered()); turn += 1u) {
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            clear_sums(sum_index(walked_tile, texel % TILE_SIZE) + i * TILE_SIZE);
        }
    }
}
