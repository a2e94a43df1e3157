// Nodes of curves during insertion, in registers: loops over them are unrolled, and indices are literals.
// Software drivers read other arrays one lane at a time.

import package::curve::lights::Lights;
import package::curve::list::Node;
import package::features::NODES;
import choice::rows::RowIs;

const node_count: u32 = NODES;

var<private> nodes: array<Node, 17>; // one more than a curve has at most
var<private> aside: Lights;

fn open_nodes(in_tile: vec2<u32>) {}

fn node_at(i: u32) -> Node {
    return nodes[i];
}

fn set_node(i: u32, node: Node) {
    nodes[i] = node;
}

fn lay_aside(light: Lights, overfull: RowIs) {
    aside = light;
}

fn lay_kept() {}

fn laid_aside() -> Lights {
    return aside;
}
