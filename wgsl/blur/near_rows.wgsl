// blur, nearest depths, rows: the nearest translucent depth of each row's window, its alpha, which is part of
// the owner tag, and the first depth of the window's curves, which also hold casters too faint for a nearest
// depth.

import package::bind::sampled::{curves, filters, nearests};
import package::bind::stored::near_rows;
import package::curve::node::{DEPTHS, curve_layer, node_start};
import package::features::NODES;
import package::records::view::GpuView;

fn curve_start(view: GpuView, at: vec2<i32>) -> f32 {
    if NODES == 0u {
        return 1.0;
    }
    let start = node_start(textureLoad(curves, at, curve_layer(view.layer, 0u), 0).xy);
    return select(1.0, (start - 1.0) / DEPTHS, start > 0.0);
}

fn start(view: GpuView, at: vec2<i32>) -> vec3<f32> {
    return vec3(1.0, textureLoad(filters, at, view.layer, 0).a, 1.0);
}

fn add(near: vec3<f32>, view: GpuView, at: vec2<i32>, off: i32) -> vec3<f32> {
    let depth = textureLoad(nearests, at, view.layer, 0).r;
    let alpha = textureLoad(filters, at, view.layer, 0).a;
    let first = min(near.z, min(depth, curve_start(view, at)));
    return vec3(select(near.xy, vec2(depth, alpha), depth < near.x), first);
}

fn store(view: GpuView, at: vec2<i32>, near: vec3<f32>) {
    textureStore(near_rows, at, view.layer, vec4(near, 0.0));
}
