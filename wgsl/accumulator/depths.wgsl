// Output: opaque depth. Tiles go straight to the map, segments and scattered casters to sums, from which the
// map is resolved. CPU reference: crates/gobo-reference/src/occlude.rs, crates/gobo-reference/src/resolve.rs.

import package::bind::changed::scattered_tiles;
import package::bind::stored::opaques;
import package::features::unrolled;
import package::hit::blocks::{blocks, small_depth, stored_depth};
import package::hit::caster_hit::caster_hit;
import package::records::footprint::Footprint;
import package::records::tile::{Segment, Tile};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::{depth_to_nearness, nearness_to_depth};
import package::traversal::lane::sum_index;
import choice::accumulator::{ROWS, nearest};
import choice::sums::{clear_sums, load_nearness, raise_nearness};

fn before_tile(view: GpuView, texel: vec2<u32>, tile: Tile) {}

// Whether no caster has the tile in its box.
fn stays_empty(view: GpuView, texel: vec2<u32>, tile: Tile) -> bool {
    return tile.first >= tile.end;
}

fn store_empty(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = texel + vec2(0u, i);
        textureStore(opaques, view.origin + at, view.layer, vec4(small_depth(view, at)));
    }
}

fn store_tile(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = texel + vec2(0u, i);
        let depth = min(nearest[i], small_depth(view, at));
        textureStore(opaques, view.origin + at, view.layer, vec4(depth));
    }
}

fn before_segment(index: u32) {}

fn store_segment(segment: Segment, index: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        if nearest[i] < 1.0 {
            raise_nearness(sum_index(segment.tile, in_tile + vec2(0u, i)), depth_to_nearness(nearest[i]));
        }
    }
}

fn add(view: GpuView, footprint: Footprint, tile_xy: vec2<u32>, in_tile: vec2<u32>) {
    let middle = vec2<f32>(tile_xy * TILE_SIZE + in_tile) + 0.5;
    let hit = caster_hit(view, footprint, middle, 1.0);
    if blocks(view, footprint, middle, hit) {
        let tile = view.first_tile + tile_xy.y * view.tiles_x + tile_xy.x;
        raise_nearness(sum_index(tile, in_tile), depth_to_nearness(stored_depth(hit)));
        scattered_tiles[tile] = 1u;
    }
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < ROWS; i += 1u) {
        let sum = sum_index(tile_id, in_tile + vec2(0u, i));
        let at = tile.position * TILE_SIZE + in_tile + vec2(0u, i);
        let depth = min(nearness_to_depth(load_nearness(sum)), small_depth(view, at));
        textureStore(opaques, view.origin + at, view.layer, vec4(depth));
        clear_sums(sum);
    }
}
