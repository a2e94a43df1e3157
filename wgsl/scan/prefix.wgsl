// Prefix sums over a workgroup's invocations, by the method of `choice::scan`.

override SCAN_LANES: u32; // of the workgroup

// Sum over the invocations before one, and over all.
struct Prefix {
    before: u32,
    total: u32,
}
