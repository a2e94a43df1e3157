// bin, where pairs did not fit: first and last pair of each tile of a part. One invocation per tile. Host:
// src/shadows/parts.rs.

import package::bin::place_tile::place_tile;
import package::bind::changed::{dispatches, tile_pairs};
import package::records::dispatch::{PART_DISPATCH, PART_TILES_DISPATCH};

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn part_tiles(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = atomicLoad(&dispatches[4u * PART_DISPATCH + 3u]);
    let tile = first + id.x;
    if tile >= atomicLoad(&dispatches[4u * PART_TILES_DISPATCH + 3u]) {
        return;
    }
    let before = atomicLoad(&tile_pairs[first]);
    let range = vec2(atomicLoad(&tile_pairs[tile]), atomicLoad(&tile_pairs[tile + 1u])) - before;
    place_tile(tile, id.x, range);
}
