// Curves of an invocation's texels during insertion: one node more than a curve has. CPU reference, with the
// merge rule and its reasons: crates/gobo-reference/src/curve/mod.rs, `Streaming`.

import package::curve::bodies::{follow_insertion, follow_merge};
import package::curve::gather::{ROWS, Texel, texels};
import package::curve::merge::{cheapest_merge, merged_span};
import package::curve::node::DEPTHS;
import package::features::{HAS_GAIN, HAS_OVER, NODES, unrolled};
import package::sums::sums::BLACK;
import choice::nodes::{node_at, node_count, open_nodes, set_node};

const DARK: u32 = 64u; // 1/1024 of 65535

// Span, start << 16 | end in fixed point, 0 for an unused node; then the light behind, green << 16 | red and
// mean of the channels << 16 | blue. A vector, because compilers take longer for structs.
alias Node = vec3<u32>;

// One hit, or several, to insert where `is` holds.
struct Insertion {
    span: u32,
    light: vec3<f32>,  // transmittance of these hits
    added: vec3<f32>,  // by `over`
    passed: vec3<f32>, // transmittance of all hits so far
    is: bool,
}

var<private> disordered: u32; // hits out of order, inside a merged ramp

fn fixed(depth: f32) -> u32 {
    return clamp(u32(round(depth * DEPTHS)), 1u, 65535u);
}

fn coded(span: u32, light: vec3<f32>) -> Node {
    let mean = (light.r + light.g + light.b) * (1.0 / 3.0);
    if HAS_GAIN {
        return Node(span, pack2x16float(light.rg), pack2x16float(vec2(light.b, mean)));
    }
    // Only a late hit may brighten the light behind it past white.
    return Node(span, pack2x16unorm(light.rg), pack2x16unorm(vec2(light.b, mean)));
}

// Light in 16 bits, in fixed-point steps.
fn level(bits: u32) -> f32 {
    if HAS_GAIN {
        return unpack2x16float(bits).x;
    }
    return f32(bits);
}

fn light_behind(node: Node) -> vec3<f32> {
    if HAS_GAIN {
        return vec3(unpack2x16float(node.y), unpack2x16float(node.z).x);
    }
    return vec3<f32>(vec3(node.y, node.y >> 16u, node.z) & vec3(0xffffu)) * (1.0 / 65535.0);
}

// `in_tile`: texel of the invocation; those of a workgroup are neighbours.
fn clear_lists(in_tile: vec2<u32>) {
    disordered = 0u;
    open_nodes(in_tile);
    let unused = coded(0u, vec3(1.0));
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        for (var k = 0u; k < unrolled(node_count); k += 1u) {
            set_node(i, k, unused);
        }
    }
}

// Whether the next hit fits without a merge.
fn has_free_node(i: u32) -> bool {
    return node_at(i, 0u).x == 0u;
}

fn last_end(i: u32) -> u32 {
    return node_at(i, NODES - 1u).x & 0xffffu;
}

// Whether the light behind the last node is invisible.
fn is_saturated(i: u32) -> bool {
    let last = node_at(i, NODES - 1u);
    let most = max(max(last.y & 0xffffu, last.y >> 16u), last.z & 0xffffu);
    return (most < DARK) & !(HAS_GAIN || HAS_OVER);
}

// Inserts hits into the list of texel `i`. A full list then has one node too many, until `merge_lists`.
fn insert(t: ptr<function, Texel>, i: u32, hit: Insertion) {
    let is_last = node_at(i, NODES - 1u).x <= hit.span;
    // Nothing behind black is visible: there a walk may stop.
    let counts = hit.is & !(is_last & is_saturated(i));
    let index = insert_between(t, i, hit, is_last, counts);
    let fits = counts & has_free_node(i);
    (*t).overfull = counts & !has_free_node(i);
    (*t).alone = follow_insertion((*t).alone, index, counts, fits);
    for (var k = 0u; k < unrolled(node_count); k += 1u) {
        set_node(i, k, select(node_at(i, k), node_at(i, k + 1u), fits));
    }
}

// Adds a node behind or between the others; those behind it move back, and are dimmed. Without a hit the new
// node goes last. Returns its index.
fn insert_between(t: ptr<function, Texel>, i: u32, hit: Insertion, is_last: bool, counts: bool) -> u32 {
    let span = select(0xffffffffu, hit.span, counts);
    var before = coded(0u, vec3(1.0));
    var index = 0u;
    for (var k = 0u; k < unrolled(node_count); k += 1u) {
        let node = node_at(i, k);
        let in_front = node.x <= span;
        before = select(before, node, in_front);
        index += select(0u, 1u, in_front);
    }
    let start = hit.span >> 16u;
    let inside = ((before.x >> 16u) < start) & ((before.x & 0xffffu) > start);
    var disorders = counts & (start < (*t).latest) & inside;
    (*t).latest = select((*t).latest, max((*t).latest, start), counts);
    let reached = light_behind(before);
    var behind = reached * hit.light;
    var dimming = hit.light;
    if HAS_OVER {
        behind += hit.added;
        dimming += hit.added / max(reached, vec3(BLACK));
        let adds = hit.added.r + hit.added.g + hit.added.b > 0.0;
        disorders = disorders | (counts & !is_last & adds);
    }
    disordered += u32(disorders);
    let came = coded(span, select(behind, hit.passed, is_last));
    for (var n = 0u; n < unrolled(node_count + 1u); n += 1u) {
        let k = NODES - n;
        let node = node_at(i, k);
        let front = node_at(i, max(k, 1u) - 1u);
        let moves = (front.x > span) & (k > 0u);
        let here = !moves & ((node.x > span) | (k == NODES));
        let dimmed = coded(front.x, light_behind(front) * dimming);
        set_node(i, k, select(select(node, came, here), dimmed, moves));
    }
    return index;
}

// Whether some list has one node too many.
fn must_merge() -> bool {
    var some = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        some = some | texels[i].overfull;
    }
    return some;
}

// Merges the two neighbours whose merge costs least, in lists with one node too many: replaces the first by
// the merge, and moves the nodes behind the second up by one.
fn merge_lists() {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let best = cheapest_merge(i);
        let overfull = texels[i].overfull;
        texels[i].alone = follow_merge(texels[i].alone, best, overfull);
        texels[i].overfull = false;
        let index = select(NODES, best.index, overfull);
        let merged = merged_span(best);
        for (var k = 0u; k < unrolled(node_count); k += 1u) {
            var node = select(node_at(i, k + 1u), node_at(i, k), k < index);
            node.x = select(node.x, merged, k == index);
            set_node(i, k, node);
        }
    }
}
