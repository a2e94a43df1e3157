// bin, buckets: room for the pairs of each tile, and its record; cuts long tiles into segments. One
// invocation per tile. Which of two workgroups is first decides where a tile's pairs are, and nothing else.
// CPU reference: crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bin::record_tile::record_tile;
import package::bind::changed::{counters, tile_cursors};
import package::bind::uniform::bin_params;
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

var<workgroup> start: u32; // of the workgroup's pairs

@compute @workgroup_size(SCAN_LANES)
fn bucket_place(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = id.x;
    var count = 0u;
    if tile < bin_params.tile_count {
        count = atomicLoad(&tile_cursors[tile]);
    }
    let prefix = prefix_sum(lane, count);
    if lane == 0u {
        start = atomicAdd(&counters.pair_count, prefix.total);
        atomicAdd(&counters.pairs_needed, prefix.total);
    }
    let first = workgroupUniformLoad(&start) + prefix.before;
    if tile < bin_params.tile_count {
        atomicStore(&tile_cursors[tile], first);
        record_tile(tile, tile, vec2(first, first + count));
    }
}
