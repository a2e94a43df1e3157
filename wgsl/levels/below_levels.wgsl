// Children of a block: 4 x 4 blocks of the level below, weighted by a quadratic B-spline, which is a sum of
// four of half its width. Blocks that don't overlap show as beads along thin bars that are slanted against
// them.

import package::curve::mean::{Ramp, light_before, next_ramp, ramp_shift};
import package::curve::node::node_of_pair;
import package::levels::child_owner::child_owner;
import package::records::area::{LevelMap, block_nodes, block_number, level_map, leveled_view};
import package::records::view::GpuView;

var<private> child_view: GpuView;
var<private> child_leveled: u32;
var<private> child_level: u32;
var<private> child_map: LevelMap;
var<private> first_face: u32;
var<private> first_child: vec2<i32>;
var<private> child_weight: f32;
var<private> child_block: u32;

fn open_child(view: GpuView, leveled: u32, level: u32, at: vec2<i32>) {
    child_view = view;
    child_leveled = leveled;
    child_level = level - 1u;
    child_map = level_map(view, leveled, child_level);
    first_face = leveled_view(leveled).z;
    first_child = 2 * at - 1;
}

fn child_count() -> u32 {
    return 16u;
}

fn start_child(i: u32) {
    let step = vec2(i % 4u, i / 4u);
    let at = first_child + vec2<i32>(step);
    let owner = child_owner(child_view, child_leveled, first_face, child_map.size, child_map.edge, at);
    child_block = block_number(level_map(owner.view, owner.leveled, child_level), owner.at);
    ramp_shift = owner.shift;
    let is_inner = (step == vec2(1u)) | (step == vec2(2u));
    let shares = select(vec2(0.125), vec2(0.375), is_inner);
    child_weight = shares.x * shares.y;
    light_before = vec3(1.0);
}

fn child_share() -> f32 {
    return child_weight;
}

fn ramp_count() -> u32 {
    return 4u;
}

fn child_ramp(k: u32) -> Ramp {
    return next_ramp(node_of_pair(block_nodes(child_block, k / 2u), k));
}
