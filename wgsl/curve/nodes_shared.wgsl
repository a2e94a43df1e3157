// Nodes of curves during insertion, in workgroup memory: each texel has its own, so that no invocation waits.

import package::bind::uniform::views;
import package::curve::lights::Lights;
import package::curve::list::Node;
import package::features::NODES;

const NODE_LANES: u32 = 64u; // of a workgroup

var<workgroup> nodes: array<array<Node, NODE_LANES>, NODES + 1u>;
var<private> lane_slot: u32;
var<private> node_count: u32;
var<private> kept_light: Lights;

// `in_tile`: texel of the invocation; those of a workgroup are 8 x 8 neighbours.
fn open_nodes(in_tile: vec2<u32>) {
    lane_slot = (in_tile.y & 7u) * 8u + (in_tile.x & 7u);
    // Always `NODES`. Compilers must not know: they would unroll loops, with all nodes in registers.
    node_count = select(0u, NODES, views[0].tiles_x > 0u);
}

fn node_at(i: u32) -> Node {
    return nodes[i][lane_slot];
}

fn set_node(i: u32, node: Node) {
    nodes[i][lane_slot] = node;
}

// Keeps light between insertions in the node that is free then: after the merge where one is due.
fn lay_aside(light: Lights, overfull: bool) {
    kept_light = light;
    if !overfull {
        lay_kept();
    }
}

fn lay_kept() {
    set_node(NODES, Node(
        bitcast<u32>(kept_light.red), bitcast<u32>(kept_light.green), bitcast<u32>(kept_light.blue),
    ));
}

fn laid_aside() -> Lights {
    let node = node_at(NODES);
    return Lights(bitcast<f32>(node.span), bitcast<f32>(node.colors), bitcast<f32>(node.means));
}
