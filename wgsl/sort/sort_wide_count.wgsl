// sort_wide_count: histogram of the digits of each block. One workgroup per block. Rust:
// src/stage/sort/mod.rs.

import package::bind::loaded::pairs;
import package::bind::stored::histograms;
import package::bind::uniform::sort_pass;
import package::sort::sort::{pair_count, texel_from_pair};
import package::sort::wide::{BLOCK, WORKGROUP_SIZE, histogram_texel};

var<workgroup> counters: array<atomic<u32>, 256>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_wide_count(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let count = pair_count();
    let begin = block.x * BLOCK;
    if begin >= count {
        return;
    }
    let end = min(begin + BLOCK, count);
    let shift = sort_pass.shift;
    let mask = sort_pass.digit_count - 1u;
    // Counting does not depend on order, so consecutive lanes read consecutive pairs.
    for (var i = begin + lane; i < end; i += WORKGROUP_SIZE) {
        let key = textureLoad(pairs, texel_from_pair(i)).x;
        atomicAdd(&counters[(key >> shift) & mask], 1u);
    }
    workgroupBarrier(); // all pairs are counted
    if lane <= mask {
        let in_block = atomicLoad(&counters[lane]);
        textureStore(histograms, histogram_texel(block.x, lane), vec4(in_block, 0u, 0u, 0u));
    }
}
