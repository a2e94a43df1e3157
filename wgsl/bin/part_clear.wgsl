// bin, where pairs may not fit: sets the pair count of every tile to zero. One invocation per tile. Rust:
// src/shadows/batch/parts.rs.

import package::bind::changed::tile_pairs;
import package::bind::uniform::bin_params;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn part_clear(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < bin_params.tile_count {
        atomicStore(&tile_pairs[id.x], 0u);
    }
}
