// Writes a tile's pairs into its bucket: depth key and footprint, in any order.

import package::bind::changed::{bucketed, tile_cursors};
import package::bind::loaded::keys;
import package::records::record::record_texel;

fn see(count: u32) {}

fn put_tile(tile: u32, footprint: u32) {
    let key = textureLoad(keys, record_texel(footprint)).r;
    let slot = atomicAdd(&tile_cursors[tile], 1u);
    bucketed[slot] = vec2(key, footprint);
}
