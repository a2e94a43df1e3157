// cull, list: chunks for `project`, view by view, in order. One invocation per (view, group) combination.
// Rust: src/stage/load.rs.

import package::bind::changed::{chunks, listed_counts};
import package::bind::uniform::cull_params;
import package::load::cull::{both_counts, chunks_of, cull_blocks, cull_entries, footprints_of};
import package::records::chunk::Chunk;
import package::records::host::CHUNK_SIZE;
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

@compute @workgroup_size(SCAN_LANES)
fn cull_list(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let entry = block.x * SCAN_LANES + lane;
    let entries = cull_entries();
    var count = 0u;
    if entry < entries {
        count = listed_counts[entry];
    }
    let before = prefix_sum(lane, both_counts(count)).before;
    if count > 0u {
        let at = entries + block.x;
        let chunk = listed_counts[at] + chunks_of(before);
        let first_footprint = listed_counts[at + cull_blocks()] + footprints_of(before);
        let group = cull_params.first_group + entry % cull_params.group_count;
        let caster = cull_params.first_caster + group * CHUNK_SIZE;
        chunks[chunk] = Chunk(entry / cull_params.group_count, caster, count, first_footprint);
    }
}
