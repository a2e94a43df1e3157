// blur, curves: the mean curve of a row's window, then that of a column's window from the rows' means. CPU
// reference: crates/gobo-reference/src/blur.rs. Rust: src/stage/blur.rs.

import package::bind::sampled::{near_around, raw_curves, rows};
import package::bind::stored::curves;
import package::bind::uniform::views;
import package::blur::separable::COLUMN;
import package::blur::window::{gaussian, sees, window};
import package::curve::mean::{Ramp, find_parts, light_before, next_ramp, part_node};
import package::curve::node::{curve_layer, node_of_pair};
import package::features::NODES;
import package::records::view::GpuView;

// A child is a curve of the window.
var<private> child_view: GpuView;
var<private> first_child: vec2<i32>; // in the atlas
var<private> first_off: i32;
var<private> child_near: f32;
var<private> per_weight: f32;
var<private> tap_share: f32;
var<private> child_at: vec2<i32>;

fn along() -> vec2<i32> {
    return select(vec2(1, 0), vec2(0, 1), COLUMN);
}

fn child_weight(i: u32) -> f32 {
    let weight = gaussian(first_off + i32(i));
    let at = first_child + along() * i32(i);
    if COLUMN {
        return weight * textureLoad(rows, at, child_view.layer, 0).w * per_weight;
    }
    return select(0.0, weight * per_weight, sees(child_view, at, child_near));
}

// Sets the window around a texel.
fn open_window(view: GpuView, at: vec2<i32>, near: f32, ends: vec2<i32>) {
    child_view = view;
    first_off = ends.x;
    first_child = at + along() * ends.x;
    child_near = near;
    per_weight = 1.0;
    var sum = 0.0;
    if COLUMN {
        for (var i = 0; i <= ends.y - ends.x; i += 1) {
            sum += child_weight(u32(i));
        }
        per_weight = 1.0 / max(sum, 1e-6);
    } else {
        per_weight = 1.0 / max(textureLoad(rows, at, view.layer, 0).w, 1e-30);
    }
}

fn start_child(i: u32) {
    child_at = first_child + along() * i32(i);
    light_before = vec3(1.0);
    tap_share = child_weight(i);
}

fn child_share() -> f32 {
    return tap_share;
}

fn child_ramp(k: u32) -> Ramp {
    let nodes = textureLoad(raw_curves, child_at, curve_layer(child_view.layer, k / 2u), 0);
    var ramp = next_ramp(node_of_pair(nodes, k));
    ramp.start = select(0.0, ramp.start, tap_share > 0.0);
    return ramp;
}

@compute @workgroup_size(8, 8)
fn blur_curves(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    let size = vec2<i32>(view.size);
    if any(texel >= size) {
        return;
    }
    let at = vec2<i32>(view.origin) + texel;
    let near = textureLoad(near_around, at, view.layer, 0).b;
    let before = dot(texel, along());
    let ends = window(before, dot(size, along()) - 1 - before);
    // Windows without translucent casters have no children.
    let children = select(u32(ends.y - ends.x + 1), 0u, near >= 1.0);
    let ramps = select(NODES, 0u, near >= 1.0);
    open_window(view, at, near, ends);
    find_parts(children, ramps, NODES);
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        let first = part_node(2u * pair, children, ramps);
        let second = part_node(2u * pair + 1u, children, ramps);
        textureStore(curves, at, curve_layer(view.layer, pair), vec4(first, second));
    }
}
