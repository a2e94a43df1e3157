// accumulate, segments: adds one segment of a long tile to the sums of its texels. One workgroup
// per segment, a column of texels per invocation; atomics, because segments of a tile run side by side.
// CPU twin: src/cpu/accumulate.rs. Host: src/stage/accumulate.rs.
// Needs common/gather.wgsl and what it needs, lane.wgsl, tile.wgsl, walk_*.wgsl, sums_*.wgsl.
@group(0) @binding(4) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(5) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(6) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> segments: array<Segment>;
@group(0) @binding(8) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(9) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(10) var casters: texture_2d<u32>;
@group(0) @binding(11) var setups: texture_2d<u32>;
@group(0) @binding(12) var images: texture_2d_array<f32>;
@group(0) @binding(13) var opaques: texture_2d_array<f32>;

@compute @workgroup_size(LANES)
fn accumulate_segments(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup.y * workgroups.x + workgroup.x;
    if index >= dispatches[SEGMENT_DISPATCH].w {
        return;
    }
    let segment = segments[index];
    let view = views[segment.view];
    let place = lane_texel(lane);
    let texel = tile_texel(view, segment.tile) + place;
    start(view, texel);
    walk(view, segment.first, segment.end);
    // A copy: what a loop indexes is memory, and what the walk changes should be registers.
    var own: array<vec4<f32>, 8>;
    own[0] = own_texel(0u);
    own[1] = own_texel(1u);
    own[2] = own_texel(2u);
    own[3] = own_texel(3u);
    if ROWS > 4u {
        own[4] = own_texel(4u);
        own[5] = own_texel(5u);
        own[6] = own_texel(6u);
        own[7] = own_texel(7u);
    }
    for (var i = 0u; i < ROWS; i += 1u) {
        let sum = sum_index(segment.tile, place + vec2(0u, i));
        merge(sum, bitcast<vec3<u32>>(vec3<i32>(round(to_tau(own[i].rgb) * FIXED_ONE))));
        if own[i].a < 1.0 {
            raise_nearness(sum, depth_to_nearness(own[i].a));
        }
    }
}

// Light that passed, and the nearest depth.
fn own_texel(i: u32) -> vec4<f32> {
    return vec4(passed_texel(i), nearest_texel(i));
}
