// Depth maps of a host, and maps in a layout of the host. CPU reference: crates/gobo-reference/src/import.rs.
// Rust: crates/gobo-reference/src/import.rs, `ImportParams` in src/records/import.rs, src/stage/import.rs,
// `ConvertParams` in src/records/convert.rs, src/shadows/look_ups/converted.rs.

import package::bind::changed::converted;
import package::bind::sampled::{filters, host_depths, nearests};
import package::bind::uniform::{convert_params, import_params};
import package::bind::updated::opaques;
import package::records::texel::opaque_bits;

// Ray of a texel of our map in the clip space of a host's camera with the same rays: clip coordinates are
// `slope * distance + start`, `distance` along our axis [m].
struct ClipRay {
    slope: vec4<f32>,
    start: vec4<f32>,
}

// `across`: offset from the axis, in a perspective view at 1 m along it [m].
fn clip_ray(clip: mat4x4<f32>, across: vec2<f32>, perspective: f32) -> ClipRay {
    let spreads = perspective > 0.0;
    let slope = select(-clip[2], clip * vec4(across, -1.0, 0.0), spreads);
    return ClipRay(slope, select(clip * vec4(across, 0.0, 1.0), clip[3], spreads));
}

// `texel`: a point of our map [texels].
fn across_axis(texel: vec2<f32>, size: vec2<f32>, scale: f32) -> vec2<f32> {
    return (texel - size * 0.5) / scale * vec2(1.0, -1.0);
}

// Import of one view's depth map from the host.
struct ImportParams {
    clip_from_view: mat4x4<f32>, // the host's clip space from our view space
    size: vec2<f32>,       // of our map [texels]
    host_size: vec2<f32>,  // of the host's [texels]
    scale: f32,            // as in `GpuView`
    perspective: f32,      // 1 or 0, of our view
    near: f32,             // [m]
    far: f32,              // [m]
    origin: vec2<u32>,     // in the atlas [texels]
    layer: u32,
    replaces: u32,         // 1: replaces the depth of our own opaque casters
    empty: f32,            // the host's clear depth
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}

override WORKGROUP_EDGE: u32;

fn light_depth(params: ImportParams, ray: ClipRay, depth: f32) -> f32 {
    let distance = (depth * ray.start.w - ray.start.z) / (ray.slope.z - depth * ray.slope.w);
    let light_depth = (distance - params.near) / (params.far - params.near);
    // A surface in front of the near plane still blocks. A NaN is no surface.
    return select(1.0, clamp(light_depth, 0.0, 1.0), depth != params.empty && light_depth <= 1.0);
}

// import: the host's depth map -> opaque depths of a view. One invocation per texel.
@compute @workgroup_size(WORKGROUP_EDGE, WORKGROUP_EDGE)
fn import_depths(@builtin(global_invocation_id) id: vec3<u32>) {
    let params = import_params;
    let middle = vec2<f32>(id.xy) + 0.5;
    if any(middle > params.size) {
        return;
    }
    let across = across_axis(middle, params.size, params.scale);
    let ray = clip_ray(params.clip_from_view, across, params.perspective);
    let seen = ray.slope * params.far + ray.start;
    let pixel = (seen.xy / seen.w * vec2(0.5, -0.5) + 0.5) * params.host_size;
    let texel = clamp(pixel, vec2(0.0), params.host_size - 1.0);
    let imported = light_depth(params, ray, textureLoad(host_depths, vec2<u32>(texel), 0).x);
    let at = params.origin + id.xy;
    let depth = bitcast<f32>(opaque_bits(imported, false));
    let known = textureLoad(opaques, at, params.layer).x;
    textureStore(opaques, at, params.layer, vec4(select(min(depth, known), depth, params.replaces == 1u)));
}

// Conversion of a view's maps to a layout of the host.
struct ConvertParams {
    clip_from_view: mat4x4<f32>, // the host's clip space from our view space
    size: vec2<f32>,       // of the map [texels]
    scale: f32,            // as in `GpuView`
    perspective: f32,      // 1 or 0
    near: f32,             // [m]
    far: f32,              // [m]
    origin: vec2<u32>,     // in the atlas [texels]
    layer: u32,
    width: u32,            // of the atlas [texels]
    has_depth: u32,        // 1: alpha is the host's depth of the nearest translucent hit
    empty: f32,            // alpha without a translucent hit
}

const FORMAT_RGBA16FLOAT: u32 = 0u;
const FORMAT_RGBA8UNORM: u32 = 1u;
const FORMAT_RG11B10UFLOAT: u32 = 2u;

override FORMAT: u32 = 0u;

// Depth that the host's rasterizer would have written.
fn host_depth(params: ConvertParams, texel: vec2<f32>, nearest: f32) -> f32 {
    let across = across_axis(texel, params.size, params.scale);
    let ray = clip_ray(params.clip_from_view, across, params.perspective);
    let clip = ray.slope * (params.near + nearest * (params.far - params.near)) + ray.start;
    return select(params.empty, clip.z / clip.w, nearest < 1.0);
}

// Leading bits of a non-negative half, rounded to nearest, at most the largest finite value.
fn short_float(x: f32, bits: u32) -> u32 {
    let half = pack2x16float(vec2(x, 0.0)) & 0xffffu;
    let lost = 15u - bits;
    let rounded = (half + ((1u << lost) >> 1u)) >> lost;
    return min(rounded, (0x7c00u >> lost) - 1u);
}

// convert: filters and nearest depths of a view -> texels in a format of the host, packed into words of a
// buffer, which every device can copy to a texture. One invocation per texel.
@compute @workgroup_size(WORKGROUP_EDGE, WORKGROUP_EDGE)
fn convert_maps(@builtin(global_invocation_id) id: vec3<u32>) {
    let params = convert_params;
    let middle = vec2<f32>(id.xy) + 0.5;
    if any(middle > params.size) {
        return;
    }
    let at = params.origin + id.xy;
    let light = textureLoad(filters, at, params.layer, 0).rgb;
    let nearest = textureLoad(nearests, at, params.layer, 0).x;
    let alpha = select(1.0, host_depth(params, middle, nearest), params.has_depth == 1u);
    let texel = at.y * params.width + at.x;
    if FORMAT == FORMAT_RGBA8UNORM {
        converted[texel] = pack4x8unorm(vec4(light, alpha));
    } else if FORMAT == FORMAT_RG11B10UFLOAT {
        let red_green = short_float(light.r, 11u) | (short_float(light.g, 11u) << 11u);
        converted[texel] = red_green | (short_float(light.b, 10u) << 22u);
    } else {
        converted[2u * texel] = pack2x16float(light.rg);
        converted[2u * texel + 1u] = pack2x16float(vec2(light.b, alpha));
    }
}
