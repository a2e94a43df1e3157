// Sums over a workgroup's invocations: those of a subgroup by its own addition, those of subgroups in turn.

import package::sort::wide::{Sums, WORKGROUP_SIZE};

const MAX_SUBGROUPS: u32 = WORKGROUP_SIZE / 4u;

// Of each subgroup.
var<workgroup> sums: array<u32, MAX_SUBGROUPS>;

fn sums_of(lane: u32, value: u32) -> Sums {
    let earlier = subgroupExclusiveAdd(value);
    let size = subgroupAdd(1u);
    workgroupBarrier(); // an earlier call may still be read
    if lane % size == size - 1u {
        sums[lane / size] = earlier + value;
    }
    workgroupBarrier(); // all have written
    var found = Sums(earlier, 0u);
    for (var i = 0u; i < WORKGROUP_SIZE / size; i += 1u) {
        found.earlier += select(0u, sums[i], i < lane / size);
        found.total += sums[i];
    }
    return found;
}
