// filter mip: a coarser level of the filter map, each texel the mean of its view's texels that it covers.
// Rust: src/shadows/smoothing/filter_mips.rs.

import package::bind::sampled::filters;
import package::bind::stored::filter_mip;
import package::bind::uniform::{blur_params, views};

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
