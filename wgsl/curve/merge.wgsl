// The cheapest merge of two neighbours among the nodes of four texels. CPU reference:
// src/reference/curve/mod.rs.

import package::curve::light4::level;
import package::curve::list::{node_lights, node_means, spans};
import package::features::NODES;
import choice::visit::ordered;

// The cheapest pair of neighbours so far.
var<private> best_cost: vec4<f32>;
var<private> best: vec4<u32>;
var<private> best_before: vec4<f32>;
var<private> best_first: vec4<u32>;  // spans
var<private> best_second: vec4<u32>;
var<private> best_next: vec4<u32>;   // of the node behind both
var<private> best_means: array<vec4<f32>, 2>;
var<private> before: vec4<f32>;

fn mean_level(i: u32) -> vec4<f32> {
    return level(node_means[i] >> vec4(16u));
}

// Cost of merging nodes i and i + 1: the area between the curve and the straight line over both; 0 if one
// of them absorbs nothing.
fn weigh(i: u32) {
    let a = spans[i];
    let b = spans[i + 1u];
    let first_mean = mean_level(i);
    let second_mean = mean_level(i + 1u);
    let first = before - first_mean;
    let second = first_mean - second_mean;
    let start = vec4<f32>(a >> vec4(16u));
    let own = first * (vec4<f32>(b & vec4(0xffffu)) - start);
    let both = first + second;
    let cost = select(
        abs(own - both * (vec4<f32>(a & vec4(0xffffu)) - start))
            + abs(own - both * (vec4<f32>(b >> vec4(16u)) - start)),
        vec4(0.0),
        first * second == vec4(0.0),
    );
    let better = cost < best_cost;
    best_cost = select(best_cost, cost, better);
    best = select(best, vec4(i), better);
    best_before = select(best_before, before, better);
    best_first = select(best_first, a, better);
    best_second = select(best_second, b, better);
    if !ordered() {
        let next = select(spans[min(i + 2u, 16u)], vec4(0xffffffffu), i + 1u == NODES);
        best_next = select(best_next, next, better);
    }
    best_means[0] = select(best_means[0], first_mean, better);
    best_means[1] = select(best_means[1], second_mean, better);
    before = first_mean;
}

// The span, changed to be no later than that of the node behind it: nodes ascend.
fn in_order(span: vec4<u32>) -> vec4<u32> {
    let first = best_next >> vec4(16u);
    let start = min(span >> vec4(16u), first);
    let end = span & vec4(0xffffu);
    return (start << vec4(16u)) | select(end, min(end, best_next & vec4(0xffffu)), start == first);
}

// Span of the ramp with the mean and variance of both, clamped to what they span.
fn merged_span() -> vec4<u32> {
    let start_a = vec4<f32>(best_first >> vec4(16u));
    let end_a = vec4<f32>(best_first & vec4(0xffffu));
    let start_b = vec4<f32>(best_second >> vec4(16u));
    let end_b = vec4<f32>(best_second & vec4(0xffffu));
    let drop_a = abs(best_before - best_means[0]);
    let drop_b = abs(best_means[0] - best_means[1]);
    let nothing = drop_a + drop_b == vec4(0.0);
    let per_both = 1.0 / select(drop_a + drop_b, vec4(1.0), nothing);
    let first = drop_a * per_both;
    let second = drop_b * per_both;
    // Twice the mean, and twelve times the variance.
    let middle_a = start_a + end_a;
    let middle_b = start_b + end_b;
    let length_a = end_a - start_a;
    let length_b = end_b - start_b;
    let middle = first * middle_a + second * middle_b;
    let off_a = middle - middle_a;
    let off_b = middle - middle_b;
    let spread = first * (length_a * length_a + 3.0 * off_a * off_a)
        + second * (length_b * length_b + 3.0 * off_b * off_b);
    let half_middle = 0.5 * middle;
    let length = max(min(min(0.5 * sqrt(spread), half_middle - start_a), end_b - half_middle), vec4(0.0));
    let start = vec4<u32>(round(half_middle - length));
    let end = vec4<u32>(round(half_middle + length));
    let span = select((start << vec4(16u)) | end, best_second, nothing);
    if ordered() {
        return span;
    }
    return in_order(span);
}

// Moves the nodes behind a merge up by one.
fn close_up(i: u32, at: vec4<u32>, merged: vec4<u32>) {
    let stays = vec4(i) < at;
    spans[i] = select(select(spans[i + 1u], spans[i], stays), merged, vec4(i) == at);
    node_lights[i] = select(node_lights[i + 1u], node_lights[i], stays);
    node_means[i] = select(node_means[i + 1u], node_means[i], stays);
}
