// Writes a tile's pairs into its bucket: depth key and footprint, in any order.

import package::bind::changed::{bucketed, tile_cursors};
import choice::records::key_record;

fn see(count: u32) {}

fn put_tile(tile: u32, footprint: u32) {
    let slot = atomicAdd(&tile_cursors[tile], 1u);
    bucketed[slot] = vec2(key_record(footprint).x, footprint);
}
