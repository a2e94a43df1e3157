// Nodes and hits that an invocation keeps in registers.

import package::curve::list::Node;
import package::features::{NODES, unrolled};
import package::hit::hit_order::{NO_HIT, OrderedHit, WAITING};
import choice::rows::ROW_COUNT;

// Nodes of curves during insertion, in registers: loops over them are unrolled, and indices are literals.
// Software drivers read other arrays one lane at a time.

const node_count: u32 = NODES;

var<private> nodes: array<array<Node, 17>, ROW_COUNT>; // one more than a curve has at most
var<private> aside: array<vec3<f32>, ROW_COUNT>;

fn open_nodes(in_tile: vec2<u32>) {}

fn node_at(i: u32, k: u32) -> Node {
    return nodes[i][k];
}

fn set_node(i: u32, k: u32, node: Node) {
    nodes[i][k] = node;
}

fn lay_aside(i: u32, light: vec3<f32>, overfull: bool) {
    aside[i] = light;
}

fn lay_kept(i: u32) {}

fn laid_aside(i: u32) -> vec3<f32> {
    return aside[i];
}

// Hits of rays that wait, in registers, nearest first.

var<private> waiting: array<array<OrderedHit, WAITING>, ROW_COUNT>;

fn clear_waiting(i: u32) {
    for (var k = 0u; k < unrolled(WAITING); k += 1u) {
        waiting[i][k] = NO_HIT;
    }
}

fn selected_hit(a: OrderedHit, b: OrderedHit, is: bool) -> OrderedHit {
    return OrderedHit(
        select(a.depth, b.depth, is),
        select(a.light, b.light, is),
        select(a.added, b.added, is),
        select(a.presence, b.presence, is),
        select(a.end, b.end, is),
        select(a.change, b.change, is),
    );
}

// Adds a hit; takes the nearest of it and those that wait.
fn exchange_hits(i: u32, came: OrderedHit) -> OrderedHit {
    var left = came;
    for (var n = 1u; n < unrolled(WAITING + 1u); n += 1u) {
        let right = waiting[i][WAITING - n];
        let stays = left.depth < right.depth;
        waiting[i][WAITING - n] = selected_hit(left, right, stays);
        left = selected_hit(right, left, stays);
    }
    return left;
}

// Takes the nearest hit, when no more are added.
fn take_hit(i: u32) -> OrderedHit {
    let left = waiting[i][0];
    for (var k = 1u; k < unrolled(WAITING); k += 1u) {
        waiting[i][k - 1u] = waiting[i][k];
    }
    waiting[i][WAITING - 1u] = NO_HIT;
    return left;
}
