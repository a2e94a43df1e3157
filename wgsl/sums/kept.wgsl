// Output: the sums themselves, for maps that are merged with others. CPU reference:
// crates/gobo-reference/src/sums.rs.

import package::bind::stored::kept_sums;
import package::features::unrolled;
import package::records::tile::{Segment, Tile};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::scatter::merge_in_steps;
import package::traversal::lane::sum_index;
import choice::accumulator::{ROWS, totals};
import choice::sums::{clear_sums, load_nearness, load_sums, raise_nearness};

fn before_tile(view: GpuView, texel: vec2<u32>, tile: Tile) {}

// Whether no caster has the tile in its box.
fn stays_empty(view: GpuView, texel: vec2<u32>, tile: Tile) -> bool {
    return tile.first >= tile.end;
}

fn store_empty(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        textureStore(kept_sums, view.origin + texel + vec2(0u, i), view.layer, vec4(0u));
    }
}

fn store_tile(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        textureStore(kept_sums, view.origin + texel + vec2(0u, i), view.layer, totals[i]);
    }
}

fn before_segment(index: u32) {}

fn store_segment(segment: Segment, index: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let sum = sum_index(segment.tile, in_tile + vec2(0u, i));
        merge_in_steps(sum, totals[i].xyz);
        raise_nearness(sum, totals[i].w);
    }
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < ROWS; i += 1u) {
        let sum = sum_index(tile_id, in_tile + vec2(0u, i));
        let at = view.origin + tile.position * TILE_SIZE + in_tile + vec2(0u, i);
        textureStore(kept_sums, at, view.layer, vec4(load_sums(sum), load_nearness(sum)));
        clear_sums(sum);
    }
}
