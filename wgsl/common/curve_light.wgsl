// Light at a depth of a texel's curve. CPU twin: src/cpu/curve/mod.rs, `light_at`.
// Needs common/curve.wgsl, rolled.wgsl; the kernel binds `curves`.

// A curve may brighten.
override HAS_GAIN: bool;

var<private> seek_z: f32; // in fixed point
var<private> seek_light: vec3<f32>;  // behind the last node that starts before it
var<private> seek_before: vec3<f32>; // before that node
var<private> seek_start: f32;
var<private> seek_length: f32;

fn seek_node(node: vec2<u32>) {
    let own = node_start(node);
    let before = own > 0.0 && own < seek_z;
    seek_start = select(seek_start, own, before);
    seek_length = select(seek_length, node_length(node), before);
    seek_before = select(seek_before, seek_light, before);
    seek_light = select(seek_light, node_light(node), before);
}

fn seek_pair(view: GpuView, at: vec2<u32>, pair: u32) {
    let nodes = textureLoad(curves, at, curve_layer(view.layer, pair), 0);
    seek_node(nodes.xy);
    seek_node(nodes.zw);
}

fn curve_light(view: GpuView, at: vec2<u32>, z: f32) -> vec3<f32> {
    seek_z = z * DEPTHS;
    seek_light = vec3(1.0);
    seek_before = vec3(1.0);
    seek_start = 0.0;
    seek_length = 0.0;
    for (var pair = 0u; ROLLED && pair < NODES / 2u; pair += 1u) {
        seek_pair(view, at, pair);
    }
    if !ROLLED {
        seek_pair(view, at, 0u);
        seek_pair(view, at, 1u);
    }
    if !ROLLED && NODES > 4u {
        seek_pair(view, at, 2u);
        seek_pair(view, at, 3u);
    }
    if !ROLLED && NODES > 8u {
        seek_pair(view, at, 4u);
        seek_pair(view, at, 5u);
        seek_pair(view, at, 6u);
        seek_pair(view, at, 7u);
    }
    let share = clamp((seek_z - seek_start) / max(seek_length, 1e-6), 0.0, 1.0);
    return seek_before + (seek_light - seek_before) * share;
}
