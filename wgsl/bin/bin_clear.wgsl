// bin, clear: sets the counters, workgroup counts and scattered tiles of a list to zero, before its other
// kernels. One invocation per tile. Rust: src/stage/bin.rs.

import package::bind::changed::{counters, dispatches, scattered_tiles, tile_cursors};
import package::bind::uniform::bin_params;

override WORKGROUP_SIZE: u32; // at least as many as `dispatches` has words

fn clear_counters() {
    atomicStore(&counters.pairs_needed, 0u);
    atomicStore(&counters.pair_count, 0u);
    atomicStore(&counters.visible, 0u);
    atomicStore(&counters.scattered, 0u);
    atomicStore(&counters.overflowed, 0u);
    atomicStore(&counters.segment_count, 0u);
    atomicStore(&counters.merged_count, 0u);
    atomicStore(&counters.disordered, 0u);
    atomicStore(&counters.in_parts, 0u);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_clear(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = id.x;
    if tile < bin_params.tile_count {
        scattered_tiles[tile] = 0u;
    }
    // Only lists with few pairs have cursors.
    if tile < min(bin_params.tile_count, arrayLength(&tile_cursors)) {
        atomicStore(&tile_cursors[tile], 0u);
    }
    if tile < arrayLength(&dispatches) {
        atomicStore(&dispatches[tile], 0u);
    }
    if tile == 0u {
        clear_counters();
    }
}
