// colored, segments: adds one segment of a long tile to the nearest opaque depths by channel. One
// workgroup per segment, four texels per invocation; atomics, because segments of a tile run side
// by side. CPU twin: src/cpu/colored.rs. Host: src/stage/colored.rs.
// Needs common/gather_colored.wgsl and what it needs, lane.wgsl, tile.wgsl, walk_*.wgsl,
// sums_*.wgsl.
@group(0) @binding(4) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(5) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(6) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> segments: array<Segment>;
@group(0) @binding(8) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(9) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(10) var casters: texture_2d<u32>;
@group(0) @binding(11) var setups: texture_2d<u32>;
@group(0) @binding(12) var images: texture_2d_array<f32>;

@compute @workgroup_size(LANES)
fn colored_segments(
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
    start(view, tile_texel(view, segment.tile) + place);
    walk(view, segment.first, segment.end);
    for (var i = 0u; i < 4u; i += 1u) {
        if any(nearest[i] < vec3(1.0)) {
            raise_channels(sum_index(segment.tile, place + vec2(0u, i)), nearnesses(nearest[i]));
        }
    }
}
