// bin, count: how many pairs each run of the depth-sorted footprints has. One invocation per run.
// `project` has sorted what touches no tile to the end.
// CPU twin: src/cpu/bin.rs. Host: src/stage/bin.rs. Needs common/record.wgsl, bin.wgsl.
@group(0) @binding(0) var<uniform> params: BinParams;
@group(0) @binding(1) var sorted: texture_storage_2d<rg32uint, read>;
@group(0) @binding(2) var rects: texture_storage_2d<rg32uint, read>;
@group(0) @binding(3) var<storage, read_write> run_offsets: array<u32>;
@group(0) @binding(4) var<storage, read_write> counters: BatchCounters;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_count(@builtin(global_invocation_id) id: vec3<u32>) {
    let run = id.x;
    if run >= params.run_count {
        return;
    }
    let first = run * params.run_length;
    let end = min(first + params.run_length, params.footprint_count);
    var pairs = 0u;
    var visible = 0u;
    for (var i = first; i < end; i += 1u) {
        let footprint = textureLoad(sorted, record_texel(i)).g;
        let count = rect_count(textureLoad(rects, record_texel(footprint)).rg);
        visible += min(count, 1u);
        pairs += select(0u, count, pairs + count <= RUN_PAIRS);
    }
    run_offsets[run] = pairs;
    atomicAdd(&counters.visible, visible);
}
