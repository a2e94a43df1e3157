// shade, casters: the light that reaches the middle of each translucent caster through the shadow
// maps. One invocation per footprint of the camera's view.
// CPU twin: src/cpu/shade.rs. Host: src/stage/shade.rs. Needs common/receive.wgsl, record.wgsl.
@group(0) @binding(0) var<uniform> params: PictureParams;
@group(0) @binding(1) var<uniform> lights: array<GpuLight, MAX_LIGHTS>;
@group(0) @binding(2) var<uniform> shadow_views: array<GpuView, MAX_SHADOW_VIEWS>;
@group(0) @binding(3) var footprints: texture_storage_2d<rgba32uint, read>;
@group(0) @binding(4) var rects: texture_storage_2d<rg32uint, read>;
@group(0) @binding(5) var casters: texture_2d<u32>;
@group(0) @binding(6) var triangles: texture_2d<u32>;
@group(0) @binding(7) var filters: texture_2d_array<f32>;
@group(0) @binding(8) var nearests: texture_2d_array<f32>;
@group(0) @binding(9) var opaques: texture_2d_array<f32>;
@group(0) @binding(10) var lit: texture_storage_2d<rgba16float, write>;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_casters(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let footprint = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if footprint >= params.footprint_count {
        return;
    }
    if textureLoad(rects, record_texel(footprint)).g == 0u {
        return;
    }
    let caster = textureLoad(footprints, record_texel(footprint * FOOTPRINT_TEXELS + 1u)).w;
    var point: vec3<f32>;
    var bias = params.bias;
    if (caster & TRIANGLE_BIT) != 0u {
        let first = (caster & ~TRIANGLE_BIT) * 5u;
        let a = bitcast<vec3<f32>>(textureLoad(triangles, record_texel(first), 0).xyz);
        let b = bitcast<vec3<f32>>(textureLoad(triangles, record_texel(first + 1u), 0).xyz);
        let c = bitcast<vec3<f32>>(textureLoad(triangles, record_texel(first + 2u), 0).xyz);
        point = (a + b + c) / 3.0;
    } else {
        let place = bitcast<vec4<f32>>(textureLoad(casters, record_texel(caster * 2u), 0));
        point = place.xyz;
        // Not its own shadow.
        bias += place.w;
    }
    // Scattered alike in all directions.
    var light = params.ambient;
    for (var i = 0u; i < params.light_count; i += 1u) {
        let arriving = incoming(lights[i], point);
        if any(arriving.radiance > vec3(1e-4)) {
            light += arriving.radiance * shadow(lights[i], point, vec3(0.0), bias) * (0.5 / 3.14159265);
        }
    }
    textureStore(lit, record_texel(footprint), vec4(light, 1.0));
}
