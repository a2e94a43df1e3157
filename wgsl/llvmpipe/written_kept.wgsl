// Nodes are kept in registers, and stored after the walk: stores that some lanes wait for cost more.

import package::curve::node::packed_node;
import package::curve::ray::{ROWS, Texel, corner};
import package::features::{NODES, unrolled};
import package::records::view::GpuView;
import choice::output::store_nodes;

const WALKS_APART: bool = true; // each walk has code of its own, without the state of the other

struct KeptNodes {
    nodes: array<vec2<u32>, 16>,
}

var<private> kept_nodes: array<KeptNodes, ROWS>;

fn put_node(view: GpuView, t: ptr<function, Texel>, i: u32, number: u32, node: vec2<u32>, is: bool) {
    for (var k = 0u; k < unrolled(NODES); k += 1u) {
        kept_nodes[i].nodes[k] = select(kept_nodes[i].nodes[k], node, is & (number == k));
    }
}

fn end_nodes(view: GpuView, t: ptr<function, Texel>, i: u32) {
    let unused = packed_node(0u, 0.0, vec3(1.0));
    for (var pair = 0u; pair < unrolled(NODES / 2u); pair += 1u) {
        let first = select(unused, kept_nodes[i].nodes[2u * pair], (*t).used > 2u * pair);
        let second = select(unused, kept_nodes[i].nodes[2u * pair + 1u], (*t).used > 2u * pair + 1u);
        store_nodes(view, corner, i, pair, vec4(first, second));
    }
}
