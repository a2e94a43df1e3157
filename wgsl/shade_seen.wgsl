// shade, seen: the nearest solid caster of each pixel of a long tile, one segment at a time; one
// workgroup per segment, four pixels per invocation. shade_surfaces takes the nearest of them.
// CPU twin: src/cpu/shade/mod.rs. Host: src/stage/shade.rs.
// Needs common/gather_seen.wgsl and what it needs, lane.wgsl, tile.wgsl, walk_*.wgsl.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(2) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> segments: array<Segment>;
@group(0) @binding(4) var<storage, read_write> partials: array<vec4<u32>>;
@group(0) @binding(5) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(6) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(7) var casters: texture_2d<u32>;
@group(0) @binding(8) var setups: texture_2d<u32>;
@group(0) @binding(9) var images: texture_2d_array<f32>;

@compute @workgroup_size(LANES)
fn shade_seen(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup.y * workgroups.x + workgroup.x;
    if index >= dispatches[SEGMENT_DISPATCH].w {
        return;
    }
    let segment = segments[index];
    let view = camera();
    let place = lane_texel(lane);
    start(view, tile_texel(view, segment.tile) + place);
    walk(view, segment.first, segment.end);
    for (var i = 0u; i < 4u; i += 1u) {
        let partial = vec4(bitcast<u32>(nearest[i]), seen[i], setup_of[i], walked);
        partials[sum_index(index, place + vec2(0u, i))] = partial;
    }
}
