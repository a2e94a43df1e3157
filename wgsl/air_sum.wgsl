// air, sum: from the eye through the slices of a column of pixels. One invocation per column.
// CPU twin: src/cpu/air.rs. Host: src/stage/air.rs. Needs common/view.wgsl, air_params.wgsl.
@group(0) @binding(0) var<uniform> views: array<GpuView, MAX_VIEWS>;
@group(0) @binding(1) var<uniform> air_params: AirParams;
@group(0) @binding(2) var sources: texture_2d_array<f32>;
@group(0) @binding(3) var air: texture_storage_2d_array<rgba32float, write>;

const AIR_CELL: u32 = 4u;

@compute @workgroup_size(8, 8)
fn air_sum(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(air)) {
        return;
    }
    let view = views[0];
    let slope = ((vec2<f32>(id.xy) + 0.5) * f32(AIR_CELL) - view.size * 0.5) / view.scale;
    let length = (view.far - view.near) / f32(air_params.slices) * sqrt(1.0 + dot(slope, slope));
    let taken = 1.0 - exp(-air_params.density * length);
    var light = vec3(0.0);
    var left = 1.0;
    let slices = min(air_params.slices, textureNumLayers(air));
    for (var k = 0u; k < slices; k += 1u) {
        light += textureLoad(sources, id.xy, k, 0).rgb * (left * taken);
        left *= 1.0 - taken;
        textureStore(air, id.xy, k, vec4(light, left));
    }
}
