// Children of a row's window: the curves of its texels.

import package::bind::sampled::{curves, rows};
import package::bind::stored::row_curves;
import package::blur::sight::sees;
import package::blur::window::{gaussian, window_ends};
import package::curve::mean::{Ramp, light_before, next_ramp};
import package::curve::node::{curve_layer, node_of_pair};
import package::records::view::GpuView;

var<private> child_view: GpuView;
var<private> first_child: vec2<i32>; // in the atlas
var<private> first_off: i32;
var<private> child_near: f32;
var<private> per_weight: f32;
var<private> own_share: f32;
var<private> child_at: vec2<i32>;

fn window_texels(view: GpuView, texel: vec2<i32>) -> u32 {
    let ends = window_ends(texel.x, i32(view.size.x));
    return u32(ends.y - ends.x + 1);
}

fn open_child(view: GpuView, texel: vec2<i32>, near: f32) {
    let at = vec2<i32>(view.origin) + texel;
    child_view = view;
    first_off = window_ends(texel.x, i32(view.size.x)).x;
    first_child = at + vec2(first_off, 0);
    child_near = near;
    per_weight = 1.0 / max(textureLoad(rows, at, view.layer, 0).w, 1e-30);
}

fn start_child(i: u32) {
    child_at = first_child + vec2(i32(i), 0);
    light_before = vec3(1.0);
    let weight = gaussian(first_off + i32(i)) * per_weight;
    own_share = select(0.0, weight, sees(child_view, child_at, child_near));
}

fn child_share() -> f32 {
    return own_share;
}

fn child_ramp(k: u32) -> Ramp {
    let nodes = textureLoad(curves, child_at, curve_layer(child_view.layer, k / 2u), 0);
    var ramp = next_ramp(node_of_pair(nodes, k));
    ramp.start = select(0.0, ramp.start, own_share > 0.0);
    return ramp;
}

fn store_nodes(at: vec2<i32>, layer: u32, nodes: vec4<u32>) {
    textureStore(row_curves, at, layer, nodes);
}
