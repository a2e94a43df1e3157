// sort_wide_scan: counts of blocks -> pairs with the same digit in earlier blocks, and the digit's
// total. One workgroup per digit. Rust: src/stage/sort/mod.rs.

import package::records::record::TOTAL_ROW;
import package::sort::sort::pair_count;
import package::sort::wide::{BLOCK, WORKGROUP_SIZE};
import choice::scan::prefix_sum;
import choice::writes::{counted, write_count};

@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_wide_scan(
    @builtin(workgroup_id) digit: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block_count = (pair_count() + BLOCK - 1u) / BLOCK;
    var total = 0u;
    for (var begin = 0u; begin < block_count; begin += WORKGROUP_SIZE) {
        let at = vec2(begin + lane, digit.x);
        var in_block = 0u;
        if at.x < block_count {
            in_block = counted(at);
        }
        let prefix = prefix_sum(lane, in_block);
        if at.x < block_count {
            write_count(at, total + prefix.before);
        }
        total += prefix.total;
    }
    if lane == 0u {
        write_count(vec2(digit.x, TOTAL_ROW), total);
    }
}
