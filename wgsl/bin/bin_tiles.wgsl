// bin, tiles: first and last pair of each tile in the pairs sorted by tile; cuts long tiles into segments.
// One invocation per tile. CPU twin: src/reference/bin.rs. Host: src/stage/bin.rs.

import package::bin::raise_dispatch::raise_dispatch;
import package::bind::changed::{counters, merged_tiles, scattered_tiles, segments};
import package::bind::loaded::pairs;
import package::bind::stored::tiles;
import package::bind::uniform::{bin_params, views};
import package::records::dispatch::{MERGED_DISPATCH, SEGMENT_DISPATCH};
import package::records::record::{bounded, record_texel};
import package::records::tile::{Segment, Tile, tile_record};

override WORKGROUP_SIZE: u32;

// First pairs of a tile and of the one after it, by bisection.
fn pair_range(tile: u32) -> vec2<u32> {
    var low = vec2(0u);
    var high = vec2(atomicLoad(&counters.pair_count));
    while any(low < high) {
        let middle = low + (high - low) / 2u;
        let before = vec2(
            textureLoad(pairs, record_texel(middle.x)).r < tile,
            textureLoad(pairs, record_texel(middle.y)).r <= tile,
        ) & (low < high);
        high = select(middle, high, before);
        low = select(low, middle + 1u, before);
    }
    return low;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_tiles(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = id.x;
    if tile >= bin_params.tile_count {
        return;
    }
    var view = 0u;
    let view_count = bounded(bin_params.view_count, textureDimensions(tiles));
    for (var i = 1u; i < view_count; i += 1u) {
        view = select(view, i, views[i].first_tile <= tile);
    }
    let range = pair_range(tile);
    let needed = (range.y - range.x + bin_params.segment_length - 1u) / bin_params.segment_length;
    let merged = needed > 1u || scattered_tiles[tile] != 0u;
    let number = tile - views[view].first_tile;
    let place = vec2(number % views[view].tiles_x, number / views[view].tiles_x);
    var record = Tile(range.x, range.y, 0u, view, place);
    if !merged {
        textureStore(tiles, record_texel(tile), tile_record(record));
        return;
    }
    let slot = atomicAdd(&counters.segment_count, needed);
    record.merged = slot + 1u;
    textureStore(tiles, record_texel(tile), tile_record(record));
    let merged_slot = atomicAdd(&counters.merged_count, 1u);
    merged_tiles[merged_slot] = tile;
    raise_dispatch(MERGED_DISPATCH, merged_slot + 1u, 1u);
    raise_dispatch(SEGMENT_DISPATCH, slot + needed, 1u);
    for (var i = 0u; i < needed; i += 1u) {
        let first = range.x + i * bin_params.segment_length;
        segments[slot + i] = Segment(tile, first, min(first + bin_params.segment_length, range.y), view);
    }
}
