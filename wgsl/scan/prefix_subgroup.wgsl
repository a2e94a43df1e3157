// Prefix sums by subgroup addition, then over the workgroup's subgroups in turn.

import package::scan::prefix::{Prefix, SCAN_LANES};

var<workgroup> sums: array<u32, SCAN_LANES>; // of each subgroup

fn prefix_sum(lane: u32, value: u32) -> Prefix {
    let before = subgroupExclusiveAdd(value);
    let size = subgroupAdd(1u);
    workgroupBarrier(); // an earlier call may still be read
    if lane % size == size - 1u {
        sums[lane / size] = before + value;
    }
    workgroupBarrier(); // all have written
    var prefix = Prefix(before, 0u);
    for (var i = 0u; i < SCAN_LANES / size; i += 1u) {
        let sum = sums[i];
        prefix.before += select(0u, sum, i < lane / size);
        prefix.total += sum;
    }
    return prefix;
}
