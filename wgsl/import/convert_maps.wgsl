// convert: filters and nearest depths of a view -> texels in a format of the host, packed into words of a
// buffer, which every device can copy to a texture. One invocation per texel. Rust:
// src/shadows/look_ups/converted.rs.

import package::bind::changed::converted;
import package::bind::sampled::{filters, nearests};
import package::bind::uniform::convert_params;
import package::import::clip_ray::{across_axis, clip_ray};
import package::records::convert::{ConvertParams, FORMAT_RG11B10UFLOAT, FORMAT_RGBA8UNORM};

override WORKGROUP_EDGE: u32;
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
