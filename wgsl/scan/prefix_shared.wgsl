// Prefix sums in workgroup memory (Hillis and Steele 1986).

import package::scan::prefix::{Prefix, SCAN_LANES};

var<workgroup> sums: array<u32, SCAN_LANES>;

fn prefix_sum(lane: u32, value: u32) -> Prefix {
    workgroupBarrier(); // an earlier call may still be read
    sums[lane] = value;
    workgroupBarrier();
    for (var reach = 1u; reach < SCAN_LANES; reach *= 2u) {
        var sum = sums[lane];
        if lane >= reach {
            sum += sums[lane - reach];
        }
        workgroupBarrier(); // all have read
        sums[lane] = sum;
        workgroupBarrier(); // all have written
    }
    return Prefix(sums[lane] - value, sums[SCAN_LANES - 1u]);
}
