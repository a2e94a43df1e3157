// Children of a block of the first level: 2 x 2 texels of a map.

import package::bind::sampled::{curves, filters, nearests, opaques};
import package::bind::uniform::picture_params;
import package::curve::mean::{Ramp, light_before, next_ramp, ramp_shift};
import package::curve::node::{DEPTHS, curve_layer, node_of_pair};
import package::features::NODES;
import package::levels::child_owner::child_owner;
import package::records::area::leveled_view;
import package::records::view::GpuView;

var<private> child_view: GpuView;
var<private> child_leveled: u32;
var<private> first_face: u32;
var<private> first_child: vec2<i32>; // in the view's map
var<private> child_layer: u32;
var<private> child_at: vec2<u32>;    // in the atlas

fn open_child(view: GpuView, leveled: u32, level: u32, at: vec2<i32>) {
    child_view = view;
    child_leveled = leveled;
    first_face = leveled_view(leveled).z;
    first_child = 2 * at;
}

fn child_count() -> u32 {
    return 4u;
}

fn start_child(i: u32) {
    let at = first_child + vec2<i32>(vec2(i % 2u, i / 2u));
    let owner = child_owner(child_view, child_leveled, first_face, vec2<i32>(child_view.size), 1.0, at);
    child_layer = owner.view.layer;
    child_at = owner.view.origin + vec2<u32>(owner.at);
    ramp_shift = owner.shift;
    light_before = vec3(1.0);
}

fn child_share() -> f32 {
    return 0.25;
}

// Ramps of translucent casters, then of the opaque surface, one per channel.
fn ramp_count() -> u32 {
    return max(NODES, 1u) + 3u;
}

fn fixed_depth(depth: f32) -> f32 {
    return clamp(round(depth * DEPTHS), 1.0, DEPTHS);
}

fn opaque_ramp(channel: u32) -> Ramp {
    let depths = textureLoad(opaques, child_at, child_layer, 0).rgb;
    let by_channel = picture_params.colored != 0u;
    let depth = select(depths.r, depths[channel], by_channel);
    let is_channel = vec3(channel) == vec3(0u, 1u, 2u);
    let all_at_once = select(vec3(0.0), light_before, channel == 0u);
    let drop = select(all_at_once, select(vec3(0.0), light_before, is_channel), by_channel);
    return Ramp(select(0.0, fixed_depth(depth), depth < 1.0), 0.0, drop);
}

fn child_ramp(k: u32) -> Ramp {
    if k >= max(NODES, 1u) {
        return opaque_ramp(k - max(NODES, 1u));
    }
    if NODES > 0u {
        let nodes = textureLoad(curves, child_at, curve_layer(child_layer, k / 2u), 0);
        return next_ramp(node_of_pair(nodes, k));
    }
    let nearest = textureLoad(nearests, child_at, child_layer, 0).r;
    let light = textureLoad(filters, child_at, child_layer, 0).rgb;
    let drop = light_before - light;
    let is = nearest < 1.0;
    light_before = select(light_before, light, is);
    return Ramp(select(0.0, fixed_depth(nearest), is), 0.0, drop);
}
