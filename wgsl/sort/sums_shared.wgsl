// Sums over a workgroup's invocations in its memory (Hillis, Steele 1986).

import package::sort::wide::{Sums, WORKGROUP_SIZE};

var<workgroup> sums: array<u32, WORKGROUP_SIZE>;

fn sums_of(lane: u32, value: u32) -> Sums {
    workgroupBarrier(); // an earlier call may still be read
    sums[lane] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < WORKGROUP_SIZE; reach *= 2u) {
        var sum = sums[lane];
        if lane >= reach {
            sum += sums[lane - reach];
        }
        workgroupBarrier(); // all have read
        sums[lane] = sum;
        workgroupBarrier(); // all have written
    }
    return Sums(sums[lane] - value, sums[WORKGROUP_SIZE - 1u]);
}
