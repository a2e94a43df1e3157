// Children of a block of the first level: 2 x 2 texels of a map.

import package::bind::sampled::{filters, nearests, opaques};
import package::bind::uniform::picture_params;
import package::curve::mean::{Ramp, light_before, next_ramp};
import package::curve::node::{DEPTHS, node_of_pair, used_nodes};
import package::curve::pages::{CurvePlace, curve_place, nodes_at};
import package::features::NODES;
import package::levels::level_blocks::{child_owner, shifted};
import package::records::area::leveled_view;
import package::records::view::GpuView;

var<private> child_view: GpuView;
var<private> child_leveled: u32;
var<private> first_face: u32;
var<private> first_child: vec2<i32>; // in the view's map
var<private> child_layer: u32;
var<private> child_at: vec2<u32>;    // in the atlas
var<private> child_curve: CurvePlace;
var<private> child_shift: vec2<f32>;
var<private> most_nodes: u32;        // of a child
var<private> opaque_count: u32;      // ramps of opaque surfaces

fn open_child(view: GpuView, leveled: u32, level: u32, at: vec2<i32>) {
    child_view = view;
    child_leveled = leveled;
    first_face = leveled_view(leveled).z;
    first_child = 2 * at;
    most_nodes = 0u;
    var is_opaque = false;
    for (var i = 0u; i < CHILDREN; i += 1u) {
        start_child(i);
        let depths = textureLoad(opaques, child_at, child_layer, 0).rgb;
        let some = depths < vec3(1.0);
        is_opaque = is_opaque | select(some.r, any(some), by_channel());
        if NODES > 0u {
            for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
                let nodes = nodes_at(child_curve, pair);
                most_nodes = max(most_nodes, used_nodes(nodes, pair));
            }
        } else {
            let nearest = textureLoad(nearests, child_at, child_layer, 0).r;
            most_nodes = max(most_nodes, select(0u, 1u, nearest < 1.0));
        }
    }
    opaque_count = select(0u, select(1u, 3u, by_channel()), is_opaque);
}

const CHILDREN: u32 = 4u;

// Whether opaque depths differ by channel.
fn by_channel() -> bool {
    return picture_params.colored != 0u;
}

fn start_child(i: u32) {
    let at = first_child + vec2<i32>(vec2(i % 2u, i / 2u));
    let owner = child_owner(child_view, child_leveled, first_face, vec2<i32>(child_view.size), 1.0, at);
    child_layer = owner.view.layer;
    child_at = owner.view.origin + vec2<u32>(owner.at);
    child_shift = owner.shift;
    if NODES > 0u {
        child_curve = curve_place(child_at, child_layer);
    }
    light_before = vec3(1.0);
}

fn child_share() -> f32 {
    return 0.25;
}

// Ramps of translucent casters, then of the opaque surface, one per channel where they differ. Behind its
// last used node a child has no ramps.
fn ramp_count() -> u32 {
    return most_nodes + opaque_count;
}

fn fixed_depth(depth: f32) -> f32 {
    return clamp(round(depth * DEPTHS), 1.0, DEPTHS);
}

fn opaque_ramp(channel: u32) -> Ramp {
    let depths = textureLoad(opaques, child_at, child_layer, 0).rgb;
    let depth = select(depths.r, depths[channel], by_channel());
    let is_channel = vec3(channel) == vec3(0u, 1u, 2u);
    let all_at_once = select(vec3(0.0), light_before, channel == 0u);
    let drop = select(all_at_once, select(vec3(0.0), light_before, is_channel), by_channel());
    return Ramp(select(0.0, fixed_depth(depth), depth < 1.0), 0.0, drop);
}

fn child_ramp(k: u32) -> Ramp {
    return shifted(own_ramp(k), child_shift);
}

// Ramp `k` in the depths of the child's own view.
fn own_ramp(k: u32) -> Ramp {
    if k >= most_nodes {
        return opaque_ramp(k - most_nodes);
    }
    if NODES > 0u {
        let nodes = nodes_at(child_curve, k / 2u);
        return next_ramp(node_of_pair(nodes, k));
    }
    let nearest = textureLoad(nearests, child_at, child_layer, 0).r;
    let light = textureLoad(filters, child_at, child_layer, 0).rgb;
    let drop = light_before - light;
    let is = nearest < 1.0;
    light_before = select(light_before, light, is);
    return Ramp(select(0.0, fixed_depth(nearest), is), 0.0, drop);
}
