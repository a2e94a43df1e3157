// Curves of four texels in a column during insertion: one node more than a curve has, each texel's in a
// component. CPU reference, with the merge rule and its reasons: src/reference/curve/mod.rs, `Streaming`.
//
// Indices are literals, so that the arrays become registers: software drivers read arrays with an
// unknown index one lane at a time.

import package::curve::bodies::{clear_bodies, follow_merge};
import package::curve::light4::{Light4, black4, encode_lights, encode_means, white4};
import package::curve::merge::{before, best, best_cost, close_up, merged_span, weigh};
import package::curve::between::insert_between;
import package::features::{HAS_GAIN, HAS_OVER, NODES};
import choice::visit::ordered;

const DARK: u32 = 64u; // 1/1024 of 65535

var<private> spans: array<vec4<u32>, 17>;  // start << 16 | end, in fixed point; 0 for an unused node
var<private> node_lights: array<vec4<u32>, 17>; // behind: green << 16 | red
var<private> node_means: array<vec4<u32>, 17>;  // mean of the channels << 16 | blue
var<private> disordered: u32;              // hits out of order, inside a merged ramp
var<private> latest: vec4<u32>;            // largest start of a hit so far
var<private> adding: Light4;               // light that the inserted hit adds, by `over`

fn clear_node(i: u32) {
    let white = white4();
    spans[i] = vec4(0u);
    node_lights[i] = encode_lights(white);
    node_means[i] = encode_means(white);
}

fn clear_list() {
    disordered = 0u;
    latest = vec4(0u);
    adding = black4();
    clear_bodies();
    clear_node(0u);
    clear_node(1u);
    clear_node(2u);
    clear_node(3u);
    if NODES > 4u {
        clear_node(4u);
        clear_node(5u);
        clear_node(6u);
        clear_node(7u);
    }
    if NODES > 8u {
        clear_node(8u);
        clear_node(9u);
        clear_node(10u);
        clear_node(11u);
        clear_node(12u);
        clear_node(13u);
        clear_node(14u);
        clear_node(15u);
    }
}

// Whether the next hit fits without a merge.
fn has_free_node() -> vec4<bool> {
    return spans[0] == vec4(0u);
}

fn last_end() -> vec4<u32> {
    return spans[NODES - 1u] & vec4(0xffffu);
}

// Whether the light behind the last node is invisible.
fn is_saturated() -> vec4<bool> {
    let last = node_lights[NODES - 1u];
    let most = max(max(last & vec4(0xffffu), last >> vec4(16u)), node_means[NODES - 1u] & vec4(0xffffu));
    return select(most < vec4(DARK), vec4(false), vec4(HAS_GAIN || HAS_OVER));
}

// Inserts one hit, or several from `start` to `end`, in each texel where `is` holds. `light`: their
// transmittance; `passed`: that of all hits so far.
fn insert(start: vec4<u32>, end: vec4<u32>, light: Light4, passed: Light4, is: vec4<bool>) {
    let counts = add_node(start, end, light, passed, is);
    best_cost = vec4(1e38);
    before = vec4(select(65535.0, 1.0, HAS_GAIN));
    weigh(0u);
    weigh(1u);
    weigh(2u);
    weigh(3u);
    if NODES > 4u {
        weigh(4u);
        weigh(5u);
        weigh(6u);
        weigh(7u);
    }
    if NODES > 8u {
        weigh(8u);
        weigh(9u);
        weigh(10u);
        weigh(11u);
        weigh(12u);
        weigh(13u);
        weigh(14u);
        weigh(15u);
    }
    let merged = merged_span();
    // Without a hit, the new node is dropped.
    let at = select(vec4(NODES), best, counts);
    follow_merge(counts);
    close_up(0u, at, merged);
    close_up(1u, at, merged);
    close_up(2u, at, merged);
    close_up(3u, at, merged);
    if NODES > 4u {
        close_up(4u, at, merged);
        close_up(5u, at, merged);
        close_up(6u, at, merged);
        close_up(7u, at, merged);
    }
    if NODES > 8u {
        close_up(8u, at, merged);
        close_up(9u, at, merged);
        close_up(10u, at, merged);
        close_up(11u, at, merged);
        close_up(12u, at, merged);
        close_up(13u, at, merged);
        close_up(14u, at, merged);
        close_up(15u, at, merged);
    }
}

// Adds one node, behind or between the others; returns where one was added.
fn add_node(start: vec4<u32>, end: vec4<u32>, light: Light4, passed: Light4, is: vec4<bool>) -> vec4<bool> {
    let span = (start << vec4(16u)) | end;
    let last = spans[NODES - 1u] <= span;
    // Nothing behind black is visible, so that a walk may stop there.
    let counts = is & !(last & is_saturated());
    if ordered() {
        spans[NODES] = span;
        node_lights[NODES] = encode_lights(passed);
        node_means[NODES] = encode_means(passed);
    } else {
        insert_between(span, light, passed, last, counts);
    }
    return counts;
}

// Like `insert`, for texels whose first node is unused.
fn append(start: vec4<u32>, end: vec4<u32>, light: Light4, passed: Light4, is: vec4<bool>) {
    let counts = add_node(start, end, light, passed, is);
    drop_first(0u, counts);
    drop_first(1u, counts);
    drop_first(2u, counts);
    drop_first(3u, counts);
    if NODES > 4u {
        drop_first(4u, counts);
        drop_first(5u, counts);
        drop_first(6u, counts);
        drop_first(7u, counts);
    }
    if NODES > 8u {
        drop_first(8u, counts);
        drop_first(9u, counts);
        drop_first(10u, counts);
        drop_first(11u, counts);
        drop_first(12u, counts);
        drop_first(13u, counts);
        drop_first(14u, counts);
        drop_first(15u, counts);
    }
}

fn drop_first(i: u32, counts: vec4<bool>) {
    spans[i] = select(spans[i], spans[i + 1u], counts);
    node_lights[i] = select(node_lights[i], node_lights[i + 1u], counts);
    node_means[i] = select(node_means[i], node_means[i + 1u], counts);
}
