// accumulate, overflow: footprints whose pairs did not fit, straight into the sums. One workgroup
// per footprint and slice of its tiles: the 65,536 tiles of a large map are more than llvmpipe lets
// one invocation walk.
// CPU twin: src/cpu/accumulate.rs. Host: src/stage/accumulate.rs. Needs common/scatter.wgsl and
// what it needs, bin.wgsl, dispatch.wgsl, sums_*.wgsl.
@group(0) @binding(4) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(5) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(6) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> overflow: array<u32>;
@group(0) @binding(8) var<storage, read_write> scattered_tiles: array<u32>;
@group(0) @binding(9) var rects: texture_2d<u32>;
@group(0) @binding(10) var footprints: texture_2d<u32>;
@group(0) @binding(11) var casters: texture_2d<u32>;
@group(0) @binding(12) var setups: texture_2d<u32>;
@group(0) @binding(13) var images: texture_2d_array<f32>;
@group(0) @binding(14) var opaques: texture_2d_array<f32>;

const OVERFLOW_LANES: u32 = 256u; // one per texel of a tile

@compute @workgroup_size(OVERFLOW_LANES)
fn accumulate_overflow(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup.y * workgroups.x + workgroup.x;
    if slot >= dispatches[OVERFLOW_DISPATCH].w {
        return;
    }
    let index = overflow[slot];
    let rect = textureLoad(rects, record_texel(index), 0).rg;
    let view = views[rect.y >> 16u];
    let place = textureLoad(footprints, record_texel(FOOTPRINT_TEXELS * index), 0);
    let look = textureLoad(footprints, record_texel(FOOTPRINT_TEXELS * index + 1u), 0);
    let first = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
    let width = last.x - first.x + 1u;
    let tile_count = width * (last.y - first.y + 1u);
    let in_tile = vec2(lane % TILE_SIZE, lane / TILE_SIZE);
    for (var k = workgroup.z; k < tile_count; k += OVERFLOW_SLICES) {
        let texel = (first + vec2(k % width, k / width)) * TILE_SIZE + in_tile;
        if all(texel < vec2<u32>(view.size)) {
            scatter(view, place, look, texel);
        }
    }
}
