// colored, tiles: nearest opaque depth of each channel, of the tiles that one workgroup finishes.
// Four texels per invocation.
// CPU twin: src/cpu/colored.rs. Host: src/stage/colored.rs.
// Needs common/gather_colored.wgsl and what it needs, lane.wgsl, tile.wgsl, walk_*.wgsl, small.wgsl.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(2) var tiles: texture_2d<u32>;
@group(0) @binding(3) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(4) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(5) var casters: texture_2d<u32>;
@group(0) @binding(6) var setups: texture_2d<u32>;
@group(0) @binding(7) var images: texture_2d_array<f32>;
@group(0) @binding(8) var opaques: texture_storage_2d_array<r32float, write>;
@group(0) @binding(9) var<storage, read> small_depths: array<u32>;
@group(0) @binding(10) var colored: texture_storage_2d_array<rgba32float, write>;

@compute @workgroup_size(LANES)
fn colored_tiles(
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
    start(view, texel);
    walk(view, tile.first, tile.end);
    for (var i = 0u; i < 4u; i += 1u) {
        let at = texel + vec2(0u, i);
        let depths = min(nearest[i], vec3(small_depth(view, at)));
        textureStore(opaques, view.origin + at, view.layer, vec4(last_depth(depths)));
        textureStore(colored, view.origin + at, view.layer, vec4(depths, 1.0));
    }
}
