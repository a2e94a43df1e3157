// resolve, ordered: filter and nearest depth of the tiles that several workgroups or the scatter
// path added to, where the order counts: a tile's segments, front to back, then what was scattered.
// Leaves the sums zero. One workgroup per tile, four texels per invocation.
// CPU twin: src/cpu/accumulate.rs, src/cpu/resolve.rs. Host: src/stage/resolve.rs.
// Needs common/volumes.wgsl, partial.wgsl, sums.wgsl, sums_*.wgsl, dispatch.wgsl, view.wgsl, tile.wgsl, lane.wgsl.
@group(0) @binding(4) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(5) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> merged_tiles: array<u32>;
@group(0) @binding(7) var tiles: texture_2d<u32>;
@group(0) @binding(8) var<storage, read> partials: array<vec4<u32>>;
@group(0) @binding(9) var filters: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(10) var nearests: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(LANES)
fn resolve_ordered(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup.y * workgroups.x + workgroup.x;
    if slot >= dispatches[MERGED_DISPATCH].w {
        return;
    }
    let id = merged_tiles[slot];
    let tile = tile_of(textureLoad(tiles, record_texel(id), 0));
    let view = views[tile.view];
    let place = lane_texel(lane);
    let room = partial_room();
    let first = tile.merged - 1u;
    let count = segment_count(tile);
    let composed = select(0u, min(count, max(room, first) - first), count > 1u);
    for (var i = 0u; i < 4u; i += 1u) {
        let sum = sum_index(id, place + vec2(0u, i));
        var passed = vec3(1.0);
        var tau = vec3(0);
        var leaves = 0;
        var owner = NO_OWNER;
        var nearest = nearness_to_depth(load_nearness(sum));
        for (var k = 0u; k < composed; k += 1u) {
            let partial = load_partial(sum_index(first + k, place + vec2(0u, i)));
            passed = passed * partial.scale + partial.added;
            owner = select(owner, partial.owner, partial.nearest < nearest);
            nearest = min(nearest, partial.nearest);
            tau += partial.tau;
            leaves += partial.leaves;
        }
        if leaves > 0 {
            nearest = 0.0; // the light is inside
        }
        tau += bitcast<vec3<i32>>(load_sums(sum));
        if !HAS_GAIN {
            tau = max(tau, vec3(0)); // a body that is not closed would brighten
        }
        passed *= light(bitcast<vec3<u32>>(tau));
        let at = view.origin + tile.place * TILE_SIZE + place + vec2(0u, i);
        var alpha = 1.0;
        if HAS_OWNERS {
            alpha = tagged_alpha(owner);
            nearest = tagged_depth(nearest, owner);
        }
        textureStore(filters, at, view.layer, vec4(blackened(passed), alpha));
        textureStore(nearests, at, view.layer, vec4(nearest));
        clear_sums(sum);
    }
}
