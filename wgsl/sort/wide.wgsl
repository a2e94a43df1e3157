// Blocks: each workgroup owns one. Round r of warp w holds pairs (w * ROUNDS + r) * 32 + lane of
// the block, so the order of pairs is (warp, round, lane). A warp here is 32 consecutive
// invocations, whatever the hardware's subgroups are.

const WORKGROUP_SIZE: u32 = 256u;
const WARP_SIZE: u32 = 32u; // bits of a mask
const WARP_COUNT: u32 = WORKGROUP_SIZE / WARP_SIZE;
const ROUNDS: u32 = 16u;    // pairs per invocation
const BLOCK: u32 = WORKGROUP_SIZE * ROUNDS; // [pairs]

var<workgroup> sums: array<u32, WORKGROUP_SIZE>;

// Sum over earlier invocations (Hillis, Steele 1986); `sums[last]` is the total.
fn exclusive_sum(lane: u32, value: u32) -> u32 {
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
    return sums[lane] - value;
}
