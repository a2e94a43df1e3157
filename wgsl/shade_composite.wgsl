// shade, composite: what is not solid over what is, and the whole to the screen. One workgroup per
// tile, four pixels per invocation.
// CPU twin: src/cpu/shade/mod.rs. Host: src/stage/shade.rs.
// Needs common/gather_layers.wgsl and what it needs, tone.wgsl, lane.wgsl, tile.wgsl, walk_*.wgsl.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(2) var<uniform> params: PictureParams;
@group(0) @binding(3) var tiles: texture_2d<u32>;
@group(0) @binding(4) var<storage, read> partials: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> pixels: array<u32>;
@group(0) @binding(6) var pairs: texture_storage_2d<rg32uint, read>;
@group(0) @binding(7) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(8) var casters: texture_2d<u32>;
@group(0) @binding(9) var setups: texture_2d<u32>;
@group(0) @binding(10) var images: texture_2d_array<f32>;
@group(0) @binding(11) var triangles: texture_2d<u32>;
@group(0) @binding(12) var lights: texture_2d<u32>;
@group(0) @binding(13) var clusters: texture_2d<u32>;
@group(0) @binding(14) var filters: texture_2d_array<f32>;
@group(0) @binding(15) var nearests: texture_2d_array<f32>;
@group(0) @binding(16) var opaques: texture_2d_array<f32>;
@group(0) @binding(17) var curves: texture_2d_array<u32>;
@group(0) @binding(18) var surfaces: texture_2d<f32>;
@group(0) @binding(19) var lit: texture_2d<f32>;
@group(0) @binding(20) var air: texture_2d_array<f32>;

@compute @workgroup_size(LANES)
fn shade_composite(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile_id = interleaved(workgroup, workgroups);
    let tile = tile_of(textureLoad(tiles, record_texel(tile_id), 0));
    let view = camera();
    let place = lane_texel(lane);
    let pixel = tile.place * TILE_SIZE + place;
    start(view, pixel);
    whole = true;
    if tile.merged == 0u {
        walk(view, tile.first, tile.end);
        finish(view);
    } else {
        let count = segment_count(tile);
        for (var k = 0u; k < 4u * count; k += 1u) {
            let i = k % 4u;
            let partial = partials[sum_index(tile.merged - 1u + k / 4u, place + vec2(0u, i))];
            walked += select(0u, partial.w & 0xffffu, i == 0u);
            asked_of[i] += partial.w >> 16u;
            let middle = unpack2x16float(partial.y);
            lay(
                i,
                vec3(unpack2x16float(partial.x), middle.x),
                vec3(middle.y, unpack2x16float(partial.z)),
            );
        }
    }
    let size = vec2<u32>(view.size);
    for (var i = 0u; i < 4u; i += 1u) {
        let at = pixel + vec2(0u, i);
        if all(at < size) {
            let surface = textureLoad(surfaces, at, 0).rgb;
            let light = color[i] + passed[i] * surface;
            var shown = pack4x8unorm(vec4(to_srgb(tone_mapped(light)), 1.0));
            if COUNT_COST {
                let cost = min(vec2(walked, asked_of[i]) + vec2<u32>(surface.rg), vec2(0xffffu));
                shown = cost.x | (cost.y << 16u);
            }
            pixels[at.y * size.x + at.x] = shown;
        }
    }
}
