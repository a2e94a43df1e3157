// cluster, scan: lights of the clusters before each cluster, in place; ALL_LIGHTS for those whose
// list does not fit. One workgroup: every invocation adds up a stretch, the stretches' sums are
// scanned in workgroup memory.
// CPU twin: src/cpu/cluster.rs. Host: src/stage/cluster.rs. Needs common/cluster.wgsl.
@group(0) @binding(0) var<uniform> params: ClusterParams;
@group(0) @binding(1) var<storage, read_write> offsets: array<u32>;
@group(0) @binding(2) var<storage, read_write> counters: ClusterCounters;

override WORKGROUP_SIZE: u32;

var<workgroup> sums: array<u32, WORKGROUP_SIZE>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn cluster_scan(@builtin(local_invocation_index) lane: u32) {
    let stretch = (params.cluster_count + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    let first = min(lane * stretch, params.cluster_count);
    let end = min(first + stretch, params.cluster_count);
    var sum = 0u;
    var longest = 0u;
    for (var cluster = first; cluster < end; cluster += 1u) {
        sum += offsets[cluster];
        longest = max(longest, offsets[cluster]);
    }
    sums[lane] = sum;
    workgroupBarrier(); // every sum before any is read
    var offset = 0u;
    for (var before = 0u; before < lane; before += 1u) {
        offset += sums[before];
    }
    var overflowed = 0u;
    for (var cluster = first; cluster < end; cluster += 1u) {
        let count = offsets[cluster];
        let fits = offset + count <= params.capacity;
        offsets[cluster] = select(ALL_LIGHTS, offset, fits);
        overflowed += select(1u, 0u, fits);
        offset += count;
    }
    atomicAdd(&counters.overflowed, overflowed);
    atomicMax(&counters.longest, longest);
    if lane == WORKGROUP_SIZE - 1u {
        atomicStore(&counters.needed, offset);
    }
}
