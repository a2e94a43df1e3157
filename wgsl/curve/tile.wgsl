// Output: the curves, filter and nearest depth of a tile that one workgroup finishes. CPU reference:
// src/reference/curve/tile.rs.

import package::bind::changed::counters;
import package::bind::read::scattered_tiles;
import package::bind::stored::{curves, filters, nearests};
import package::curve::bodies::split_bodies;
import package::curve::gather::{
    ROWS, join_ramp, join_rest, light_texel, nearest, nearest_seen, open_added, open_end, open_start,
    total_light,
};
import package::curve::light4::scaled;
import package::curve::list::{disordered, last_end};
import package::curve::node::{DEPTHS, curve_layer};
import package::curve::overflow::{is_light, nothing_overflowed, overflowed, rest_light};
import package::curve::stored::{packed_pair, packed_row};
import package::curve::volumes::{begin_inside, rest_steps};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES};
import package::records::view::GpuView;
import package::sums::sums::blackened;
import package::traversal::lane::sum_index;

var<private> own_tile: u32;
var<private> first_sum: u32;

fn before_tile(view: GpuView, texel: vec2<u32>, tile_id: u32, place: vec2<u32>) {
    own_tile = tile_id;
    first_sum = sum_index(tile_id, place);
}

// Adds what is behind all pairs: volumes that contain the light, then overflowing casters, of which few
// tiles have any.
fn open_rest(view: GpuView, step: u32) {
    if HAS_VOLUMES && step + 1u < rest_steps() {
        let ramps = join_ramp(begin_inside());
        return;
    }
    var rest = nothing_overflowed();
    if scattered_tiles[own_tile] != 0u {
        rest = overflowed(first_sum);
    }
    let light = rest_light(rest, total_light());
    let depth = select(nearest, rest.depth, rest.depth < vec4(1.0));
    let behind = max(depth, vec4<f32>(last_end()) * (1.0 / DEPTHS));
    let some = is_light(light);
    join_rest(light);
    if HAS_OVER {
        open_added = scaled(open_added, light);
    }
    open_start = select(open_start, min(open_start, behind), some);
    open_end = select(open_end, max(open_end, behind), some);
    nearest = min(nearest, rest.depth);
}

fn store_tile(view: GpuView, texel: vec2<u32>) {
    nearest = nearest_seen();
    let all = total_light();
    let at = view.origin + texel;
    for (var i = 0u; i < ROWS; i += 1u) {
        let row = at + vec2(0u, i);
        textureStore(filters, row, view.layer, vec4(blackened(light_texel(all, i)), 1.0));
        textureStore(nearests, row, view.layer, vec4(nearest[i]));
    }
    split_bodies();
    store_curves(view, at);
    if disordered > 0u {
        atomicAdd(&counters.disordered, disordered);
    }
}

// `at`: first of the four texels, in the atlas.
fn store_curves(view: GpuView, at: vec2<u32>) {
    store_pair(view, at, 0u);
    store_pair(view, at, 1u);
    if NODES > 4u {
        store_pair(view, at, 2u);
        store_pair(view, at, 3u);
    }
    if NODES > 8u {
        store_pair(view, at, 4u);
        store_pair(view, at, 5u);
        store_pair(view, at, 6u);
        store_pair(view, at, 7u);
    }
}

fn store_pair(view: GpuView, at: vec2<u32>, pair: u32) {
    let nodes = packed_pair(pair);
    let layer = curve_layer(view.layer, pair);
    textureStore(curves, at, layer, packed_row(nodes, 0u));
    textureStore(curves, at + vec2(0u, 1u), layer, packed_row(nodes, 1u));
    textureStore(curves, at + vec2(0u, 2u), layer, packed_row(nodes, 2u));
    textureStore(curves, at + vec2(0u, 3u), layer, packed_row(nodes, 3u));
}
