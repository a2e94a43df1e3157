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
