// Output: filter and nearest depth. Tiles go straight to the maps, segments and scattered casters to sums,
// from which the maps are resolved. CPU reference: crates/gobo-reference/src/accumulate.rs,
// crates/gobo-reference/src/resolve.rs.

import package::bind::stored::{filters, nearests};
import package::features::{HAS_OWNERS, unrolled};
import package::records::footprint::Footprint;
import package::records::texel::{NO_OWNER, tagged_alpha, tagged_depth};
import package::records::tile::{Segment, Tile};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::scatter::{merge, scatter};
import package::sums::sums::{FIXED_ONE, blackened, depth_to_nearness, light, nearness_to_depth, to_tau};
import package::traversal::lane::sum_index;
import choice::accumulator::{ROWS, finish, found};
import choice::maps::{plain_alpha, store_map};
import choice::sums::{clear_sums, load_nearness, load_sums, raise_nearness};

var<private> alpha_of_none: f32;

fn before_tile(view: GpuView, texel: vec2<u32>, tile: Tile) {
    alpha_of_none = plain_alpha(view.origin + texel, view.layer);
}

// Whether no caster has the tile in its box.
fn stays_empty(view: GpuView, texel: vec2<u32>, tile: Tile) -> bool {
    return tile.first >= tile.end;
}

fn store_empty(view: GpuView, texel: vec2<u32>) {
    let alpha = select(plain_alpha(view.origin + texel, view.layer), tagged_alpha(NO_OWNER), HAS_OWNERS);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        store_map(view.origin + texel + vec2(0u, i), view.layer, vec4(vec3(1.0), alpha), 1.0);
    }
}

fn store_tile(view: GpuView, texel: vec2<u32>) {
    finish();
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = view.origin + texel + vec2(0u, i);
        var depth = found[i].nearest;
        var alpha = alpha_of_none;
        if HAS_OWNERS {
            alpha = tagged_alpha(found[i].owner);
            depth = tagged_depth(depth, found[i].owner);
        }
        store_map(at, view.layer, vec4(blackened(found[i].light), alpha), depth);
    }
}

fn before_segment(index: u32) {}

fn store_segment(segment: Segment, index: u32, in_tile: vec2<u32>) {
    finish();
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let sum = sum_index(segment.tile, in_tile + vec2(0u, i));
        merge(sum, bitcast<vec3<u32>>(vec3<i32>(round(to_tau(found[i].light) * FIXED_ONE))));
        if found[i].nearest < 1.0 {
            raise_nearness(sum, depth_to_nearness(found[i].nearest));
        }
    }
}

fn add(view: GpuView, footprint: Footprint, tile_xy: vec2<u32>, in_tile: vec2<u32>) {
    scatter(view, footprint, tile_xy * TILE_SIZE + in_tile);
}

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    for (var i = 0u; i < ROWS; i += 1u) {
        let sum = sum_index(tile_id, in_tile + vec2(0u, i));
        let at = view.origin + tile.position * TILE_SIZE + in_tile + vec2(0u, i);
        textureStore(filters, at, view.layer, vec4(blackened(light(load_sums(sum))), 1.0));
        textureStore(nearests, at, view.layer, vec4(nearness_to_depth(load_nearness(sum))));
        clear_sums(sum);
    }
}
