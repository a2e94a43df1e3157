// Records of tiles and segments. CPU reference: crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bind::changed::{counters, dispatches, merged_tiles, scattered_tiles, segments};
import package::bind::uniform::{bin_params, views};
import package::records::batch::{MERGED_DISPATCH, PARTED_DISPATCH, SEGMENT_DISPATCH};
import package::records::tile::{FIRST_SEGMENT, LAST_SEGMENT, Segment, Tile};
import choice::records::pair_record;
import choice::writes::write_tile;

override WORKGROUP_SIZE: u32;

// First pairs of a tile and of the one after it, by bisection.
fn pair_range(tile: u32) -> vec2<u32> {
    var low = vec2(0u);
    var high = vec2(atomicLoad(&counters.pair_count));
    while any(low < high) {
        let middle = low + (high - low) / 2u;
        let before = vec2(
            pair_record(middle.x).x < tile,
            pair_record(middle.y).x <= tile,
        ) & (low < high);
        high = select(middle, high, before);
        low = select(low, middle + 1u, before);
    }
    return low;
}

// bin, tiles: first and last pair of each tile in the pairs sorted by tile; cuts long tiles into segments.
// One invocation per tile.
@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_tiles(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = id.x;
    // The last run ends behind all tiles, and a list in parts has its tiles recorded part by part.
    let is_there = tile < bin_params.tile_count && atomicLoad(&dispatches[4u * PARTED_DISPATCH]) == 0u;
    var range = vec2(0u);
    if is_there {
        range = pair_range(tile);
    }
    record_tile(tile, tile, range, is_there);
}

// Work of a tile whose pairs are known: one workgroup, or several segments where its pairs are many or
// casters were scattered to it.

// `index`: of the tile's record; `is_there`: whether the tile is walked, else no workgroup finishes it.
fn record_tile(tile: u32, index: u32, range: vec2<u32>, is_there: bool) {
    var view = 0u;
    let view_count = min(bin_params.view_count, arrayLength(&scattered_tiles));
    for (var i = 1u; i < view_count; i += 1u) {
        view = select(view, i, views[i].first_tile <= tile);
    }
    let needed = (range.y - range.x + bin_params.segment_length - 1u) / bin_params.segment_length;
    let scattered = scattered_tiles[tile] != 0u;
    let merged = is_there && (needed > 1u || (scattered && bin_params.adds_scattered == 0u));
    let number = tile - views[view].first_tile;
    let at = vec2(number % views[view].tiles_x, number / views[view].tiles_x);
    var slot = 0u;
    if merged {
        slot = atomicAdd(&segments.count, needed);
    }
    write_tile(index, Tile(range.x, range.y, select(u32(!is_there), slot + 1u, merged), view, at, scattered));
    if !merged {
        return;
    }
    let merged_slot = atomicAdd(&dispatches[4u * MERGED_DISPATCH + 3u], 1u);
    merged_tiles[merged_slot] = index;
    raise_dispatch(MERGED_DISPATCH, merged_slot + 1u, 1u);
    raise_dispatch(SEGMENT_DISPATCH, slot + needed, 1u);
    atomicAdd(&counters.segment_count, needed);
    atomicAdd(&counters.merged_count, 1u);
    for (var i = 0u; i < needed; i += 1u) {
        let first = range.x + i * bin_params.segment_length;
        let end = min(first + bin_params.segment_length, range.y);
        let ends = select(0u, FIRST_SEGMENT, i == 0u) | select(0u, LAST_SEGMENT, end == range.y);
        segments.all[slot + i] = Segment(tile, first, end, view | ends);
    }
}

// Workgroup counts that only the GPU knows: zero before each batch, then raised by atomicMax, so that the
// largest of many invocations stays, in whatever order they come.

const MAX_X: u32 = 32768u; // below every adapter's limit of workgroups in a row

fn raise_dispatch(dispatch: u32, count: u32, slices: u32) {
    atomicMax(&dispatches[4u * dispatch], min(count, MAX_X));
    atomicMax(&dispatches[4u * dispatch + 1u], (count + MAX_X - 1u) / MAX_X);
    atomicMax(&dispatches[4u * dispatch + 2u], slices);
}
