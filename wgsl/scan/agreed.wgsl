// A number that every invocation of a workgroup has, in a way that compilers know. Loops with barriers may
// depend on it; where they depended on uniform buffers alone, lavapipe would compile the kernel anew for each
// buffer.

var<workgroup> told: u32;

fn agreed(lane: u32, number: u32) -> u32 {
    if lane == 0u {
        told = number;
    }
    return workgroupUniformLoad(&told);
}
