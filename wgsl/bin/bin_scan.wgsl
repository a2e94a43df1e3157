// bin, scan: number of pairs in all runs before each run, in place. One workgroup: every invocation adds up
// some consecutive runs, their sums are scanned in workgroup memory. CPU reference: src/reference/bin.rs. Rust:
// src/stage/bin.rs.

import package::bind::changed::{counters, run_offsets};
import package::bind::uniform::bin_params;

override WORKGROUP_SIZE: u32;

var<workgroup> sums: array<u32, WORKGROUP_SIZE>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_scan(@builtin(local_invocation_index) lane: u32) {
    let stretch = (bin_params.run_count + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    let first = min(lane * stretch, bin_params.run_count);
    let end = min(first + stretch, bin_params.run_count);
    var sum = 0u;
    for (var run = first; run < end; run += 1u) {
        sum += run_offsets[run];
    }
    sums[lane] = sum;
    workgroupBarrier(); // every sum before any is read
    var offset = 0u;
    for (var before = 0u; before < lane; before += 1u) {
        offset += sums[before];
    }
    for (var run = first; run < end; run += 1u) {
        let count = run_offsets[run];
        run_offsets[run] = offset;
        offset += count;
    }
    if lane == WORKGROUP_SIZE - 1u {
        atomicStore(&counters.pairs_needed, offset);
        atomicStore(&counters.pair_count, offset);
    }
}
