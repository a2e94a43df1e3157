// cluster, scan: exclusive prefix sum of the clusters' light counts, in place; ALL_LIGHTS for clusters whose
// list does not fit. One workgroup: every invocation adds up some consecutive clusters, and their sums are
// scanned in workgroup memory. CPU reference: crates/gobo-reference/src/cluster.rs. Rust:
// crates/gobo-picture/src/stage/cluster.rs.

import package::bind::changed::{cluster_counters, offsets};
import package::bind::uniform::cluster_params;
import package::records::cluster::ALL_LIGHTS;

override WORKGROUP_SIZE: u32;

var<workgroup> sums: array<u32, WORKGROUP_SIZE>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn cluster_scan(@builtin(local_invocation_index) lane: u32) {
    let stretch = (cluster_params.cluster_count + WORKGROUP_SIZE - 1u) / WORKGROUP_SIZE;
    let first = min(lane * stretch, cluster_params.cluster_count);
    let end = min(first + stretch, cluster_params.cluster_count);
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
        let fits = offset + count <= cluster_params.capacity;
        offsets[cluster] = select(ALL_LIGHTS, offset, fits);
        overflowed += select(1u, 0u, fits);
        offset += count;
    }
    atomicAdd(&cluster_counters.overflowed, overflowed);
    atomicMax(&cluster_counters.longest, longest);
    if lane == WORKGROUP_SIZE - 1u {
        atomicStore(&cluster_counters.needed, offset);
    }
}
