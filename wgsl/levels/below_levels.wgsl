// Children of a block: 4 x 4 blocks of the level below, weighted by a quadratic B-spline, which is a sum of
// four of half its width. Blocks that don't overlap show as beads along thin slanted bars.

import package::curve::mean::{Ramp, light_before, next_ramp};
import package::curve::node::{node_of_pair, used_nodes};
import package::features::HAS_FACES;
import package::levels::level_blocks::{child_owner, shifted};
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
var<private> child_shift: vec2<f32>;
var<private> most_ramps: u32; // of a child

fn open_child(view: GpuView, leveled: u32, level: u32, at: vec2<i32>) {
    child_view = view;
    child_leveled = leveled;
    child_level = level - 1u;
    child_map = level_map(view, leveled, child_level);
    first_face = leveled_view(leveled).z;
    first_child = 2 * at - 1;
    most_ramps = 0u;
    for (var i = 0u; i < CHILDREN; i += 1u) {
        find_child(i);
        for (var pair = 0u; pair < 2u; pair += 1u) {
            most_ramps = max(most_ramps, used_nodes(block_nodes(child_block, pair), pair));
        }
    }
}

const CHILDREN: u32 = 16u;

fn find_child(i: u32) {
    let at = first_child + vec2<i32>(vec2(i % 4u, i / 4u));
    let owner = child_owner(child_view, child_leveled, first_face, child_map.size, child_map.edge, at);
    var map = child_map;
    if HAS_FACES {
        map = level_map(owner.view, owner.leveled, child_level);
    }
    child_block = block_number(map, owner.at);
    child_shift = owner.shift;
}

fn start_child(i: u32) {
    find_child(i);
    let step = vec2(i % 4u, i / 4u);
    let is_inner = (step == vec2(1u)) | (step == vec2(2u));
    let shares = select(vec2(0.125), vec2(0.375), is_inner);
    child_weight = shares.x * shares.y;
    light_before = vec3(1.0);
}

fn child_share() -> f32 {
    return child_weight;
}

// Behind its last used node a child has no ramps.
fn ramp_count() -> u32 {
    return most_ramps;
}

fn child_ramp(k: u32) -> Ramp {
    return shifted(next_ramp(node_of_pair(block_nodes(child_block, k / 2u), k)), child_shift);
}
