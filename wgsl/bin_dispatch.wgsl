// bin, dispatch: workgroup counts of what only the GPU knows. One invocation.
// Host: src/stage/bin.rs. Needs common/bin.wgsl, dispatch.wgsl.
@group(0) @binding(0) var<storage, read_write> counters: BatchCounters;
@group(0) @binding(1) var<storage, read_write> dispatches: array<vec4<u32>>;

const MAX_X: u32 = 32768u; // below every adapter's limit of workgroups in a row

fn rows(count: u32, slices: u32) -> vec4<u32> {
    return vec4(min(count, MAX_X), (count + MAX_X - 1u) / MAX_X, slices, count);
}

@compute @workgroup_size(1)
fn bin_dispatch() {
    dispatches[OVERFLOW_DISPATCH] = rows(atomicLoad(&counters.overflowed), OVERFLOW_SLICES);
    dispatches[SEGMENT_DISPATCH] = rows(atomicLoad(&counters.segment_count), 1u);
    dispatches[MERGED_DISPATCH] = rows(atomicLoad(&counters.merged_count), 1u);
}
