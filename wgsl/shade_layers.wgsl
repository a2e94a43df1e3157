// shade, layers: what a segment of a long tile lays over each pixel; one workgroup per segment,
// four pixels per invocation. Light L behind it becomes colour + passed * L, so that
// shade_composite composes the segments of a tile in order.
// CPU twin: src/cpu/shade/mod.rs. Host: src/stage/shade.rs.
// Needs common/gather_layers.wgsl and what it needs, lane.wgsl, tile.wgsl, walk_*.wgsl.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> materials: array<GpuMaterial, MAX_MATERIALS>;
@group(0) @binding(2) var<uniform> params: PictureParams;
@group(0) @binding(3) var<storage, read> dispatches: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> segments: array<Segment>;
@group(0) @binding(5) var<storage, read_write> partials: array<vec4<u32>>;
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

const BRIGHTEST: f32 = 60000.0; // that 16 bits hold

@compute @workgroup_size(LANES)
fn shade_layers(
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
    finish(view);
    for (var i = 0u; i < 4u; i += 1u) {
        let c = min(color[i], vec3(BRIGHTEST));
        let p = passed[i];
        let cost = walked | (asked_of[i] << 16u); // both are short of 16 bits
        let partial = vec4(pack2x16float(c.rg), pack2x16float(vec2(c.b, p.r)), pack2x16float(p.gb), cost);
        partials[sum_index(index, place + vec2(0u, i))] = partial;
    }
}
