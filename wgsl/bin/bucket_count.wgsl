// Counts a tile's pairs.

import package::bind::changed::{counters, tile_cursors};

// A footprint with so many tiles.
fn see(count: u32) {
    if count > 0u {
        atomicAdd(&counters.visible, 1u);
    }
}

fn put_tile(tile: u32, footprint: u32) {
    atomicAdd(&tile_cursors[tile], 1u);
}
