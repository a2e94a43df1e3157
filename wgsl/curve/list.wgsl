// Curves of an invocation's texels during insertion: one node more than a curve has. CPU reference, with the
// merge rule and its reasons: crates/gobo-reference/src/curve/mod.rs, `Streaming`.

import package::curve::bodies::{clear_bodies, follow_insertion, follow_merge, new_index};
import package::curve::lights::{Lights, black, decode, encode, plus, quotient, scaled, selected, white};
import package::curve::merge::{cheapest_merge, merged_span};
import package::features::{HAS_GAIN, HAS_OVER, NODES, unrolled};
import package::sums::sums::BLACK;
import choice::nodes::{node_at, node_count, open_nodes, set_node};
import choice::rows::{RowBits, RowIs, Rows, any_row, count_rows};

const DARK: u32 = 64u; // 1/1024 of 65535

struct Node {
    span: RowBits,   // start << 16 | end, in fixed point; 0 for an unused node
    colors: RowBits, // behind: green << 16 | red
    means: RowBits,  // mean of the channels << 16 | blue
}

var<private> disordered: u32; // hits out of order, inside a merged ramp
var<private> latest: RowBits; // largest start of a hit so far
var<private> adding: Lights;  // light that the inserted hit adds, by `over`
var<private> overfull: RowIs; // curves with one node too many

fn coded(span: RowBits, light: Lights) -> Node {
    let mean = (light.red + light.green + light.blue) * (1.0 / 3.0);
    return Node(
        span,
        encode(light.red) | (encode(light.green) << RowBits(16u)),
        encode(light.blue) | (encode(mean) << RowBits(16u)),
    );
}

fn light_behind(node: Node) -> Lights {
    return Lights(
        decode(node.colors & RowBits(0xffffu)),
        decode(node.colors >> RowBits(16u)),
        decode(node.means & RowBits(0xffffu)),
    );
}

fn selected_node(a: Node, b: Node, is: RowIs) -> Node {
    return Node(
        select(a.span, b.span, is),
        select(a.colors, b.colors, is),
        select(a.means, b.means, is),
    );
}

// `in_tile`: texel of the invocation; those of a workgroup are neighbours.
fn clear_list(in_tile: vec2<u32>) {
    disordered = 0u;
    latest = RowBits(0u);
    adding = black();
    overfull = RowIs(false);
    clear_bodies();
    open_nodes(in_tile);
    let unused = coded(RowBits(0u), white());
    for (var i = 0u; i < unrolled(node_count); i += 1u) {
        set_node(i, unused);
    }
}

// Whether the next hit fits without a merge.
fn has_free_node() -> RowIs {
    return node_at(0u).span == RowBits(0u);
}

fn last_end() -> RowBits {
    return node_at(NODES - 1u).span & RowBits(0xffffu);
}

// Whether the light behind the last node is invisible.
fn is_saturated() -> RowIs {
    let last = node_at(NODES - 1u);
    let colors = max(last.colors & RowBits(0xffffu), last.colors >> RowBits(16u));
    let is = max(colors, last.means & RowBits(0xffffu)) < RowBits(DARK);
    return is & RowIs(!(HAS_GAIN || HAS_OVER));
}

// Inserts one hit, or several from `start` to `end`, in each texel where `is` holds. `light`: transmittance
// of the inserted hits; `passed`: of all hits so far. A full curve then has one node too many, until
// `merge_nodes`.
fn insert(start: RowBits, end: RowBits, light: Lights, passed: Lights, is: RowIs) {
    let counts = add_node(start, end, light, passed, is);
    let fits = counts & has_free_node();
    overfull = counts & !has_free_node();
    follow_insertion(counts, fits);
    for (var i = 0u; i < unrolled(node_count); i += 1u) {
        set_node(i, selected_node(node_at(i), node_at(i + 1u), fits));
    }
}

// Whether some curve has one node too many.
fn must_merge() -> bool {
    return any_row(overfull);
}

// Merges the two neighbours whose merge costs least, in curves with one node too many.
fn merge_nodes() {
    let best = cheapest_merge();
    follow_merge(best, overfull);
    close_up(select(RowBits(NODES), best.index, overfull), merged_span(best));
    overfull = RowIs(false);
}

// Adds a node behind or between the others; returns where one was added.
fn add_node(start: RowBits, end: RowBits, light: Lights, passed: Lights, is: RowIs) -> RowIs {
    let span = (start << RowBits(16u)) | end;
    let last = node_at(NODES - 1u).span <= span;
    // Nothing behind black is visible: there a walk may stop.
    let counts = is & !(last & is_saturated());
    insert_between(span, light, passed, last, counts);
    return counts;
}

// Moves nodes behind the new one back, and dims them. Without a hit the new node goes last.
fn insert_between(span: RowBits, light: Lights, passed: Lights, last: RowIs, counts: RowIs) {
    let new_span = select(RowBits(0xffffffffu), span, counts);
    var before = coded(RowBits(0u), white());
    new_index = RowBits(0u);
    for (var i = 0u; i < unrolled(node_count); i += 1u) {
        let node = node_at(i);
        let in_front = node.span <= new_span;
        before = selected_node(before, node, in_front);
        new_index += select(RowBits(0u), RowBits(1u), in_front);
    }
    let start = span >> RowBits(16u);
    let late = counts & (start < latest);
    latest = select(latest, max(latest, start), counts);
    let inside = ((before.span >> RowBits(16u)) < start) & ((before.span & RowBits(0xffffu)) > start);
    let reached = light_behind(before);
    var behind = scaled(reached, light);
    var dimming = light;
    var lost = late & inside;
    if HAS_OVER {
        behind = plus(behind, adding);
        dimming = plus(light, quotient(adding, reached, BLACK));
        lost = lost | (counts & !last & (adding.red + adding.green + adding.blue > Rows(0.0)));
    }
    disordered += count_rows(lost);
    let came = coded(new_span, selected(behind, passed, last));
    for (var n = 0u; n < unrolled(node_count + 1u); n += 1u) {
        let i = NODES - n;
        let node = node_at(i);
        let front = node_at(max(i, 1u) - 1u);
        let moves = (front.span > new_span) & RowIs(i > 0u);
        let here = !moves & ((node.span > new_span) | RowIs(i == NODES));
        let dimmed = coded(front.span, scaled(light_behind(front), dimming));
        set_node(i, selected_node(selected_node(node, came, here), dimmed, moves));
    }
}

// Replaces node `index` and the one behind it by their merge, and moves those behind them up by one.
fn close_up(index: RowBits, merged: RowBits) {
    for (var i = 0u; i < unrolled(node_count); i += 1u) {
        var node = selected_node(node_at(i + 1u), node_at(i), RowBits(i) < index);
        node.span = select(node.span, merged, RowBits(i) == index);
        set_node(i, node);
    }
}
