// Sums over the lanes of a workgroup.

// Prefix sums over a workgroup's invocations, by the method of `choice::scan`.

override SCAN_LANES: u32; // of the workgroup

// Sum over the invocations before one, and over all.
struct Prefix {
    before: u32,
    total: u32,
}

// Prefix sums in workgroup memory (Hillis and Steele 1986).

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

// A number that every invocation of a workgroup has, by a broadcast that compilers recognise. Loops with
// barriers may depend on it; if they depended on uniform buffers alone, lavapipe would compile the kernel
// anew for each buffer.

var<workgroup> told: u32;

fn agreed(lane: u32, number: u32) -> u32 {
    if lane == 0u {
        told = number;
    }
    return workgroupUniformLoad(&told);
}
