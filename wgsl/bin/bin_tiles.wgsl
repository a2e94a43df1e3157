// bin, tiles: first and last pair of each tile in the pairs sorted by tile; cuts long tiles into segments.
// One invocation per tile. CPU reference: crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bin::record_tile::record_tile;
import package::bind::changed::{counters, dispatches};
import package::bind::loaded::pairs;
import package::bind::stored::tiles;
import package::bind::uniform::bin_params;
import package::records::dispatch::PARTED_DISPATCH;
import package::records::record::record_texel;

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
    if atomicLoad(&dispatches[4u * PARTED_DISPATCH]) != 0u {
        // The tile is walked with its part: no workgroup finishes it here.
        textureStore(tiles, record_texel(tile), vec4(0u, 0u, 1u, 0u));
        return;
    }
    record_tile(tile, tile, pair_range(tile));
}
