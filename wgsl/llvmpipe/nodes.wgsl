// Nodes and hits that an invocation keeps in registers.

import package::curve::lights::{Lights, selected};
import package::curve::list::Node;
import package::features::{NODES, unrolled};
import package::hit::hit_order::{Hits, WAITING, no_hits};
import choice::rows::RowIs;

// Nodes of curves during insertion, in registers: loops over them are unrolled, and indices are literals.
// Software drivers read other arrays one lane at a time.

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

// Hits of rays that wait, in registers, nearest first.

var<private> waiting: array<Hits, WAITING>;

fn clear_waiting() {
    for (var i = 0u; i < unrolled(WAITING); i += 1u) {
        waiting[i] = no_hits();
    }
}

fn selected_hits(a: Hits, b: Hits, is: RowIs) -> Hits {
    return Hits(
        select(a.depth, b.depth, is),
        selected(a.light, b.light, is),
        selected(a.added, b.added, is),
        select(a.presence, b.presence, is),
        select(a.end, b.end, is),
        selected(a.change, b.change, is),
    );
}

// Adds hits; takes the nearest of them and those that wait.
fn exchange_hits(came: Hits) -> Hits {
    var left = came;
    for (var n = 1u; n < unrolled(WAITING + 1u); n += 1u) {
        let right = waiting[WAITING - n];
        let stays = left.depth < right.depth;
        waiting[WAITING - n] = selected_hits(left, right, stays);
        left = selected_hits(right, left, stays);
    }
    return left;
}

// Takes the nearest hits, when no more are added.
fn take_hits() -> Hits {
    let left = waiting[0];
    for (var i = 1u; i < unrolled(WAITING); i += 1u) {
        waiting[i - 1u] = waiting[i];
    }
    waiting[WAITING - 1u] = no_hits();
    return left;
}
