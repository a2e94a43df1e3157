// bin, scan: exclusive prefix sum of the pairs of the blocks of runs, in place. One workgroup. CPU reference:
// crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bind::changed::{counters, run_offsets};
import package::bind::uniform::bin_params;
import package::scan::agreed::agreed;
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

@compute @workgroup_size(SCAN_LANES)
fn bin_scan(@builtin(local_invocation_index) lane: u32) {
    let runs = max(bin_params.block_runs, 1u);
    let block_count = agreed(lane, (bin_params.run_count + runs - 1u) / runs);
    var total = 0u;
    for (var begin = 0u; begin < block_count; begin += SCAN_LANES) {
        let block = begin + lane;
        let at = bin_params.run_count + block;
        var count = 0u;
        if block < block_count {
            count = run_offsets[at];
        }
        let prefix = prefix_sum(lane, count);
        if block < block_count {
            run_offsets[at] = total + prefix.before;
        }
        total += prefix.total;
    }
    if lane == 0u {
        atomicStore(&counters.pairs_needed, total);
        atomicStore(&counters.pair_count, total);
    }
}
