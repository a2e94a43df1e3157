// Nodes are stored in pairs, as soon as both are written.

import package::curve::node::packed_node;
import package::curve::ray::{Texel, corner};
import package::features::NODES;
import package::records::view::GpuView;
import choice::output::store_nodes;

const WALKS_APART: bool = false; // one code for both walks takes fewer registers

fn put_node(view: GpuView, t: ptr<function, Texel>, i: u32, number: u32, node: vec2<u32>, is: bool) {
    if is && number % 2u == 1u {
        store_nodes(view, corner, i, number / 2u, vec4((*t).pending, node));
    }
    (*t).pending = select((*t).pending, node, is);
}

fn end_nodes(view: GpuView, t: ptr<function, Texel>, i: u32) {
    let unused = packed_node(0u, 0.0, vec3(1.0));
    for (var k = (*t).used; k < NODES; k += 1u) {
        put_node(view, t, i, k, unused, true);
    }
}
