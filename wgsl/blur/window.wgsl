// Windows of a blur. CPU reference: crates/gobo-reference/src/blur.rs. Rust: src/stage/blur.rs,
// src/shadows/smoothing/filter_mips.rs.

import package::bind::sampled::{filters, opaques};
import package::bind::stored::filter_mip;
import package::bind::uniform::{blur_params, views};
import package::records::view::GpuView;

struct BlurParams {
    radius: i32,  // radius of the window [texels]
    scale: f32,   // factor of a squared offset in the exponent
    level: u32,   // mip level to make of the filter map, from the one before
    pad_0: u32,
}

// First and last offset of the texels that are on the map; `before`, `behind`: number of texels on either
// side.
fn window(before: i32, behind: i32) -> vec2<i32> {
    return vec2(max(-blur_params.radius, -before), min(blur_params.radius, behind));
}

fn gaussian(off: i32) -> f32 {
    return exp(f32(off * off) * blur_params.scale);
}

// Whether no opaque surface of the texel is in front of `near`, the first translucent depth of the window.
fn sees(view: GpuView, at: vec2<i32>, near: f32) -> bool {
    return textureLoad(opaques, at, view.layer, 0).r >= near;
}

// filter mip: a coarser level of the filter map, each texel the mean of its view's texels that it covers.
@compute @workgroup_size(8, 8)
fn make_filter_mip(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let size = vec2<u32>(view.size);
    let edge = 1u << (blur_params.level - 1u); // edge of a texel of the level before [texels of the map]
    if any(id.xy * 2u * edge >= size) {
        return;
    }
    var sum = vec4(0.0);
    for (var i = 0u; i < 4u; i += 1u) {
        let below = 2u * id.xy + vec2(i % 2u, i / 2u);
        let first = min(below * edge, size);
        let texels = min(first + edge, size) - first;
        let light = textureLoad(filters, view.origin / edge + below, view.layer, 0).rgb;
        let weight = f32(texels.x * texels.y);
        sum += select(vec4(0.0), vec4(light, 1.0) * weight, weight > 0.0);
    }
    let at = view.origin / (2u * edge) + id.xy;
    textureStore(filter_mip, at, view.layer, vec4(sum.rgb / sum.w, 1.0));
}
