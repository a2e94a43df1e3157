// Children of a column's window: the means of its rows' windows.

import package::bind::sampled::{row_curves, rows};
import package::bind::stored::curves;
import package::blur::window::{gaussian, window_ends};
import package::curve::mean::{Ramp, light_before, next_ramp};
import package::curve::node::{curve_layer, node_of_pair};
import package::records::view::GpuView;

var<private> child_view: GpuView;
var<private> first_child: vec2<i32>; // in the atlas
var<private> first_off: i32;
var<private> per_weight: f32;
var<private> own_share: f32;
var<private> child_at: vec2<i32>;

fn window_texels(view: GpuView, texel: vec2<i32>) -> u32 {
    let ends = window_ends(texel.y, i32(view.size.y));
    return u32(ends.y - ends.x + 1);
}

fn child_weight(i: u32) -> f32 {
    let at = first_child + vec2(0, i32(i));
    return gaussian(first_off + i32(i)) * textureLoad(rows, at, child_view.layer, 0).w;
}

fn open_child(view: GpuView, texel: vec2<i32>, near: f32) {
    child_view = view;
    first_off = window_ends(texel.y, i32(view.size.y)).x;
    first_child = vec2<i32>(view.origin) + texel + vec2(0, first_off);
    let count = window_texels(view, texel);
    var sum = 0.0;
    for (var i = 0u; i < count; i += 1u) {
        sum += child_weight(i);
    }
    per_weight = 1.0 / max(sum, 1e-6);
}

fn start_child(i: u32) {
    child_at = first_child + vec2(0, i32(i));
    light_before = vec3(1.0);
    own_share = child_weight(i) * per_weight;
}

fn child_share() -> f32 {
    return own_share;
}

fn child_ramp(k: u32) -> Ramp {
    let nodes = textureLoad(row_curves, child_at, curve_layer(child_view.layer, k / 2u), 0);
    var ramp = next_ramp(node_of_pair(nodes, k));
    ramp.start = select(0.0, ramp.start, own_share > 0.0);
    return ramp;
}

fn store_nodes(at: vec2<i32>, layer: u32, nodes: vec4<u32>) {
    textureStore(curves, at, layer, nodes);
}
