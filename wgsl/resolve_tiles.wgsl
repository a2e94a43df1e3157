// resolve, tiles: filter and nearest depth of the tiles that several workgroups or the scatter path
// added to; leaves the sums zero. One workgroup per tile, four texels per invocation.
// CPU twin: src/cpu/resolve.rs. Host: src/stage/resolve.rs.
// Needs common/sums.wgsl, sums_*.wgsl, dispatch.wgsl, view.wgsl, tile.wgsl, lane.wgsl.
@group(0) @binding(4) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(5) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> merged_tiles: array<u32>;
@group(0) @binding(7) var tiles: texture_2d<u32>;
@group(0) @binding(8) var filters: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(9) var nearests: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(LANES)
fn resolve_tiles(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup.y * workgroups.x + workgroup.x;
    if slot >= dispatches[MERGED_DISPATCH].w {
        return;
    }
    let tile_id = merged_tiles[slot];
    let tile = tile_of(textureLoad(tiles, record_texel(tile_id), 0));
    let view = views[tile.view];
    let place = lane_texel(lane);
    for (var i = 0u; i < 4u; i += 1u) {
        let sum = sum_index(tile_id, place + vec2(0u, i));
        let at = view.origin + tile.place * TILE_SIZE + place + vec2(0u, i);
        textureStore(filters, at, view.layer, vec4(blackened(light(load_sums(sum))), 1.0));
        textureStore(nearests, at, view.layer, vec4(nearness_to_depth(load_nearness(sum))));
        clear_sums(sum);
    }
}
