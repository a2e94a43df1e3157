// bin, where pairs did not fit: the next part of the tiles, as many as there is room for their pairs. One
// invocation. Host: src/shadows/parts.rs.

import package::bin::part_plan::store_dispatch;
import package::bind::changed::{dispatches, tile_pairs};
import package::bind::uniform::{bin_params, part_params};
import package::records::dispatch::{
    MERGED_DISPATCH, PART_DISPATCH, PART_TILES_DISPATCH, SEGMENT_DISPATCH,
};

const MOST_TILES: u32 = 65535u; // workgroups in a row on every adapter
const TILE_LANES: u32 = 64u;    // of `part_tiles`

@compute @workgroup_size(1)
fn part_next() {
    let first = atomicLoad(&dispatches[4u * PART_TILES_DISPATCH + 3u]);
    let before = atomicLoad(&tile_pairs[first]);
    var end = first;
    var limit = min(bin_params.tile_count, first + MOST_TILES);
    while end < limit {
        let middle = (end + limit + 1u) / 2u;
        let fits = atomicLoad(&tile_pairs[middle]) - before <= part_params.room;
        end = select(end, middle, fits);
        limit = select(middle - 1u, limit, fits);
    }
    let count = end - first;
    store_dispatch(PART_DISPATCH, vec4(count, 1u, 1u, first));
    store_dispatch(PART_TILES_DISPATCH, vec4((count + TILE_LANES - 1u) / TILE_LANES, 1u, 1u, end));
    store_dispatch(SEGMENT_DISPATCH, vec4(0u));
    store_dispatch(MERGED_DISPATCH, vec4(0u));
}
