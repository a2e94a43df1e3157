// cull, scan: exclusive prefix sums of the blocks' chunks and footprints, in place, and their totals for the
// list. One workgroup. Rust: src/stage/load.rs.

import package::bind::changed::{listed_bin_params, listed_counts, listed_project_params};
import package::bind::uniform::cull_params;
import package::load::cull::{cull_blocks, cull_entries};
import package::scan::agreed::agreed;
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

// Replaces the counts of blocks, from `first` on, by their exclusive prefix sum from `start`; returns the
// total.
fn scan_blocks(lane: u32, first: u32, start: u32) -> u32 {
    let block_count = agreed(lane, cull_blocks());
    var total = start;
    for (var begin = 0u; begin < block_count; begin += SCAN_LANES) {
        let block = begin + lane;
        var count = 0u;
        if block < block_count {
            count = listed_counts[first + block];
        }
        let prefix = prefix_sum(lane, count);
        if block < block_count {
            listed_counts[first + block] = total + prefix.before;
        }
        total += prefix.total;
    }
    return total;
}

@compute @workgroup_size(SCAN_LANES)
fn cull_scan(@builtin(local_invocation_index) lane: u32) {
    let first = cull_entries();
    let chunk_count = scan_blocks(lane, first, 0u);
    let footprint_end = scan_blocks(lane, first + cull_blocks(), cull_params.first_footprint);
    if lane == 0u {
        listed_project_params.chunk_count = chunk_count;
        listed_bin_params.footprint_count = footprint_end;
    }
}
