// Light at a depth of a texel's curve. CPU reference: src/reference/curve/mod.rs, `light_at`.

import package::bind::sampled::curves;
import package::curve::node::{DEPTHS, curve_layer, node_length, node_light, node_start};
import package::features::NODES;
import package::records::view::GpuView;

var<private> seek_z: f32; // in fixed point
var<private> seek_behind: vec3<f32>; // behind the last node that starts before it
var<private> seek_here: vec3<f32>;   // at seek_z, by that node
var<private> seek_rest: vec3<f32>;   // transmittance of earlier nodes from there on, where ramps overlap

fn seek_node(node: vec2<u32>) {
    let start = node_start(node);
    let before = start > 0.0 && start < seek_z;
    let light = node_light(node);
    let share = clamp((seek_z - start) / max(node_length(node), 1e-6), 0.0, 1.0);
    let passes = before && any(seek_here != seek_behind);
    let rest = seek_here / max(seek_behind, vec3(1e-9));
    seek_rest *= select(vec3(1.0), rest, vec3(passes) & (seek_behind > vec3(0.0)));
    seek_here = select(seek_here, seek_behind + (light - seek_behind) * share, before);
    seek_behind = select(seek_behind, light, before);
}

fn seek_pair(view: GpuView, at: vec2<u32>, pair: u32) {
    let nodes = textureLoad(curves, at, curve_layer(view.layer, pair), 0);
    seek_node(nodes.xy);
    seek_node(nodes.zw);
}

fn curve_light(view: GpuView, at: vec2<u32>, z: f32) -> vec3<f32> {
    seek_z = z * DEPTHS;
    seek_behind = vec3(1.0);
    seek_here = vec3(1.0);
    seek_rest = vec3(1.0);
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        seek_pair(view, at, pair);
    }
    return seek_rest * seek_here;
}
