// blur, nearest depths, rows: the nearest translucent depth of each row's window, its alpha, which is part
// of the owner tag, and the first depth of the window's curves, which also hold casters too faint for a
// nearest depth. CPU reference: src/reference/blur.rs. Rust: src/stage/blur.rs.

import package::bind::sampled::{curves, filters, nearests};
import package::bind::stored::near_rows;
import package::bind::uniform::views;
import package::blur::window::window_ends;
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

@compute @workgroup_size(8, 8)
fn blur_near_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    if any(texel >= vec2<i32>(view.size)) {
        return;
    }
    let at = vec2<i32>(view.origin) + texel;
    let ends = window_ends(texel.x, i32(view.size.x));
    var near = vec2(1.0, textureLoad(filters, at, view.layer, 0).a);
    var first = 1.0;
    for (var i = ends.x; i <= ends.y; i += 1) {
        let there = at + vec2(i, 0);
        let depth = textureLoad(nearests, there, view.layer, 0).r;
        let alpha = textureLoad(filters, there, view.layer, 0).a;
        first = min(first, min(depth, curve_start(view, there)));
        near = select(near, vec2(depth, alpha), depth < near.x);
    }
    textureStore(near_rows, at, view.layer, vec4(near, first, 0.0));
}
