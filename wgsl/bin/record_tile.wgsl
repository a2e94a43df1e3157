// Work of a tile whose pairs are known: one workgroup, or several segments where its pairs are many or
// casters were scattered to it.

import package::bin::raise_dispatch::raise_dispatch;
import package::bind::changed::{counters, dispatches, merged_tiles, scattered_tiles, segments};
import package::bind::stored::tiles;
import package::bind::uniform::{bin_params, views};
import package::records::dispatch::{MERGED_DISPATCH, SEGMENT_DISPATCH};
import package::records::record::{bounded, record_texel};
import package::records::tile::{Segment, Tile, tile_record};

// `index`: of the tile's record.
fn record_tile(tile: u32, index: u32, range: vec2<u32>) {
    var view = 0u;
    let view_count = bounded(bin_params.view_count, textureDimensions(tiles));
    for (var i = 1u; i < view_count; i += 1u) {
        view = select(view, i, views[i].first_tile <= tile);
    }
    let needed = (range.y - range.x + bin_params.segment_length - 1u) / bin_params.segment_length;
    let merged = needed > 1u || scattered_tiles[tile] != 0u;
    let number = tile - views[view].first_tile;
    let at = vec2(number % views[view].tiles_x, number / views[view].tiles_x);
    var record = Tile(range.x, range.y, 0u, view, at);
    if !merged {
        textureStore(tiles, record_texel(index), tile_record(record));
        return;
    }
    let slot = atomicAdd(&dispatches[4u * SEGMENT_DISPATCH + 3u], needed);
    record.merged = slot + 1u;
    textureStore(tiles, record_texel(index), tile_record(record));
    let merged_slot = atomicAdd(&dispatches[4u * MERGED_DISPATCH + 3u], 1u);
    merged_tiles[merged_slot] = index;
    raise_dispatch(MERGED_DISPATCH, merged_slot + 1u, 1u);
    raise_dispatch(SEGMENT_DISPATCH, slot + needed, 1u);
    atomicAdd(&counters.segment_count, needed);
    atomicAdd(&counters.merged_count, 1u);
    for (var i = 0u; i < needed; i += 1u) {
        let first = range.x + i * bin_params.segment_length;
        let end = min(first + bin_params.segment_length, range.y);
        segments[slot + i] = Segment(tile, first, end, view | (index << 8u));
    }
}
