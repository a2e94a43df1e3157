// Children of a block: blocks of the level below.

import package::curve::node::{node_length, node_light, node_start};
import package::curve::mean::Ramp;
import package::records::area::{LevelMap, block_nodes, block_number, level_map, leveled_view};
import package::records::light::shadow_view;

var<private> child_map: LevelMap;
var<private> first_child: vec2<i32>;
var<private> child_block: u32;
var<private> child_light: vec3<f32>; // behind the nodes so far

fn open_child(leveled: u32, level: u32, at: vec2<i32>) {
    child_map = level_map(shadow_view(leveled_view(leveled).x), leveled, level - 1u);
    first_child = 2 * at;
}

fn start_child(i: u32) {
    let at = first_child + vec2<i32>(vec2(i % 2u, i / 2u));
    child_block = block_number(child_map, min(at, child_map.size - 1));
    child_light = vec3(1.0);
}

fn child_share() -> f32 {
    return 0.25;
}

fn ramp_count() -> u32 {
    return 4u;
}

fn child_ramp(k: u32) -> Ramp {
    let nodes = block_nodes(child_block, k / 2u);
    let node = select(nodes.xy, nodes.zw, (k & 1u) != 0u);
    let start = node_start(node);
    let light = node_light(node);
    let drop = child_light - light;
    child_light = select(child_light, light, start > 0.0);
    return Ramp(start, node_length(node), drop);
}
