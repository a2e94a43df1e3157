// Light at a depth of a texel's curve: the product of its nodes, in any order. CPU reference:
// crates/gobo-reference/src/curve/format.rs, `light_at`.

import package::bind::sampled::curves;
import package::curve::node::{DEPTHS, curve_layer, node_length, node_passed, node_start};
import package::features::NODES;
import package::records::view::GpuView;

// Share of light that a node passes up to depth `z`, in fixed point.
fn passed_at(node: vec2<u32>, z: f32) -> vec3<f32> {
    let start = node_start(node);
    let share = clamp((z - start) / max(node_length(node), 1e-6), 0.0, 1.0);
    return mix(vec3(1.0), node_passed(node), select(0.0, share, start > 0.0));
}

fn curve_light(view: GpuView, at: vec2<u32>, z: f32) -> vec3<f32> {
    var light = vec3(1.0);
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        let nodes = textureLoad(curves, at, curve_layer(view.layer, pair), 0);
        light *= passed_at(nodes.xy, z * DEPTHS) * passed_at(nodes.zw, z * DEPTHS);
    }
    return light;
}
