// Output: the curves, filter and nearest depth of a tile that one workgroup finishes. CPU reference:
// crates/gobo-reference/src/curve/tile.rs.

import package::bind::changed::counters;
import package::bind::stored::{curves, filters, nearests};
import package::curve::blank::stays_blank;
import package::curve::bodies::split_bodies;
import package::curve::gather::{ROWS, corner, join_ramp, join_rest, nearest_of, texels, total_light};
import package::curve::list::{disordered, last_end};
import package::curve::node::DEPTHS;
import package::curve::overflow::{overflowed, rest_light};
import package::curve::pages::{page_of, place_in};
import package::curve::stored::{begin_stored, stored_pair};
import package::curve::volumes::{begin_inside, rest_steps};
import package::features::{HAS_VOLUMES, NODES, unrolled};
import package::records::tile::{Tile, tile_number_of};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::blackened;
import package::traversal::lane::sum_index;

var<private> walked_tile: u32;
var<private> has_scattered: bool;
var<private> is_blank: bool;

fn before_tile(view: GpuView, texel: vec2<u32>, tile: Tile) {
    walked_tile = tile_number_of(view, tile);
    has_scattered = tile.scattered;
    is_blank = stays_empty(view, texel, tile);
}

// Whether the tile has no casters, and its curves are not stored.
fn stays_empty(view: GpuView, texel: vec2<u32>, tile: Tile) -> bool {
    return stays_blank(view, texel, (tile.first < tile.end) | tile.scattered);
}

fn store_empty(view: GpuView, texel: vec2<u32>) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = view.origin + texel + vec2(0u, i);
        textureStore(filters, at, view.layer, vec4(1.0));
        textureStore(nearests, at, view.layer, vec4(1.0));
    }
}

// Whether some of the tile's casters have no pairs.
fn is_scattered() -> bool {
    return has_scattered;
}

// Steps behind all pairs: volumes that contain the light, and scattered casters, of which few tiles have any.
fn tile_steps() -> u32 {
    if HAS_VOLUMES {
        return rest_steps();
    }
    return u32(is_scattered());
}

fn open_rest(view: GpuView, step: u32) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        if HAS_VOLUMES && step + 1u < rest_steps() {
            let is_ramp = join_ramp(&texel, begin_inside(texel.unentered, step));
        } else {
            let in_tile = vec2<u32>(corner) % TILE_SIZE + vec2(0u, i);
            let rest = overflowed(sum_index(walked_tile, in_tile), is_scattered());
            let light = rest_light(texel, rest, total_light(&texel, i));
            let depth = select(texel.nearest, rest.depth, rest.depth < 1.0);
            let behind = max(depth, f32(last_end(i)) * (1.0 / DEPTHS));
            join_rest(&texel, light, behind, behind, any(light != vec3(1.0)));
            texel.nearest = min(texel.nearest, rest.depth);
        }
        texels[i] = texel;
    }
}

fn store_tile(view: GpuView, texel: vec2<u32>) {
    let at = view.origin + vec2<u32>(corner);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let texel_at = at + vec2(0u, i);
        var done = texels[i];
        textureStore(filters, texel_at, view.layer, vec4(blackened(total_light(&done, i)), 1.0));
        textureStore(nearests, texel_at, view.layer, vec4(nearest_of(done)));
    }
    for (var turn = u32(is_blank); turn < 1u; turn += 1u) {
        split_bodies();
        store_curves(view, at);
    }
    if disordered > 0u {
        atomicAdd(&counters.disordered, disordered);
    }
}

// `at`: first of the texels, in the atlas.
fn store_curves(view: GpuView, at: vec2<u32>) {
    let page = page_of(at, view.layer);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let place = place_in(page, at + vec2(0u, i), view.layer);
        var left = vec3(1.0);
        begin_stored(i);
        for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
            textureStore(curves, place.xy, place.z + pair, stored_pair(i, pair, &left));
        }
    }
}
