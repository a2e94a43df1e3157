// bin, where pairs did not fit: the next part of the tiles, as many as there is room for their pairs, and the
// first and last pair of each. One workgroup. Rust: src/shadows/batch/parts.rs.

import package::bin::part_plan::store_dispatch;
import package::bin::record_tile::record_tile;
import package::bind::changed::{dispatches, tile_pairs};
import package::bind::uniform::{bin_params, part_params};
import package::records::dispatch::{
    MERGED_DISPATCH, PARTED_DISPATCH, PART_DISPATCH, SEGMENT_DISPATCH,
};

const MAX_WORKGROUPS: u32 = 65535u; // workgroups in a row on every adapter
const TILE_LANES: u32 = 64u;

@compute @workgroup_size(TILE_LANES)
fn part_next(@builtin(local_invocation_index) lane: u32) {
    let first = atomicLoad(&dispatches[4u * PARTED_DISPATCH + 3u]);
    let before = atomicLoad(&tile_pairs[first]);
    var end = first;
    var limit = min(bin_params.tile_count, first + MAX_WORKGROUPS);
    while end < limit {
        let middle = (end + limit + 1u) / 2u;
        let fits = atomicLoad(&tile_pairs[middle]) - before <= part_params.room;
        end = select(end, middle, fits);
        limit = select(middle - 1u, limit, fits);
    }
    storageBarrier(); // every lane has read where the part begins
    if lane == 0u {
        store_dispatch(PART_DISPATCH, vec4(end - first, 1u, 1u, first));
        store_dispatch(PARTED_DISPATCH, vec4(1u, 0u, 0u, end));
        store_dispatch(SEGMENT_DISPATCH, vec4(0u));
        store_dispatch(MERGED_DISPATCH, vec4(0u));
    }
    storageBarrier(); // segments are counted from zero
    for (var tile = first + lane; tile < end; tile += TILE_LANES) {
        let range = vec2(atomicLoad(&tile_pairs[tile]), atomicLoad(&tile_pairs[tile + 1u]));
        record_tile(tile, tile - first, range - before);
    }
}
