// accumulate, tiles: filter and nearest depth of every tile that one workgroup finishes. One
// workgroup per tile, a column of texels per invocation, no atomics.
// CPU twin: src/cpu/accumulate.rs. Host: src/stage/accumulate.rs.
// Needs common/gather.wgsl and what it needs, lane.wgsl, tile.wgsl, walk_*.wgsl, maps.wgsl
// or maps_fetched.wgsl.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(2) var tiles: texture_2d<u32>;
@group(0) @binding(3) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(4) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(5) var casters: texture_2d<u32>;
@group(0) @binding(6) var setups: texture_2d<u32>;
@group(0) @binding(7) var images: texture_2d_array<f32>;
@group(0) @binding(8) var opaques: texture_2d_array<f32>;

@compute @workgroup_size(LANES)
fn accumulate_tiles(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile_id = interleaved(workgroup, workgroups);
    let tile = tile_of(textureLoad(tiles, record_texel(tile_id), 0));
    if tile.merged != 0u {
        return;
    }
    let view = views[tile.view];
    let texel = tile.place * TILE_SIZE + lane_texel(lane);
    let alpha_of_none = plain_alpha(view.origin + texel, view.layer);
    start(view, texel);
    walk(view, tile.first, tile.end);
    finish();
    for (var i = 0u; i < ROWS; i += 1u) {
        let at = view.origin + texel + vec2(0u, i);
        var nearest_depth = nearest_texel(i);
        var alpha = alpha_of_none;
        if HAS_OWNERS {
            alpha = tagged_alpha(owner_texel(i));
            nearest_depth = tagged_depth(nearest_depth, owner_texel(i));
        }
        textureStore(filters, at, view.layer, vec4(blackened(passed_texel(i)), alpha));
        textureStore(nearests, at, view.layer, vec4(nearest_depth));
    }
}
