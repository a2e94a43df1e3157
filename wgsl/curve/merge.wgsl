// The cheapest merge of two neighbours among the nodes of a curve. CPU reference:
// crates/gobo-reference/src/curve/mod.rs.

import package::curve::list::level;
import package::features::{HAS_GAIN, NODES, unrolled};
import choice::nodes::{node_at, node_count};

struct Merge {
    cost: f32,
    index: u32,        // of the pair's first node
    means: vec3<f32>,  // mean light in front of the pair, behind its first node, and behind both
    spans: vec3<u32>,  // of the pair, and of the node behind it
}

// Cost of a merge: the area between the curve and the straight line over both ramps; 0 if one of them absorbs
// nothing.
fn cheapest_merge(i: u32) -> Merge {
    var best = Merge(1e38, 0u, vec3(0.0), vec3(0u));
    var before = select(65535.0, 1.0, HAS_GAIN);
    var a = node_at(i, 0u);
    for (var k = 0u; k < unrolled(node_count); k += 1u) {
        let b = node_at(i, k + 1u);
        let next = select(node_at(i, min(k + 2u, NODES)).x, 0xffffffffu, k + 1u == NODES);
        let means = vec3(before, level(a.z >> 16u), level(b.z >> 16u));
        let first = means.x - means.y;
        let second = means.y - means.z;
        let start = f32(a.x >> 16u);
        let first_area = first * (f32(b.x & 0xffffu) - start);
        let both = first + second;
        let cost = select(
            abs(first_area - both * (f32(a.x & 0xffffu) - start))
                + abs(first_area - both * (f32(b.x >> 16u) - start)),
            0.0,
            first * second == 0.0,
        );
        let better = cost < best.cost;
        best.cost = select(best.cost, cost, better);
        best.index = select(best.index, k, better);
        best.means = select(best.means, means, better);
        best.spans = select(best.spans, vec3(a.x, b.x, next), better);
        before = means.y;
        a = b;
    }
    return best;
}

// Span of a ramp with the mean and variance of both ramps, clamped to their joint span.
fn merged_span(best: Merge) -> u32 {
    let start_a = f32(best.spans.x >> 16u);
    let end_a = f32(best.spans.x & 0xffffu);
    let start_b = f32(best.spans.y >> 16u);
    let end_b = f32(best.spans.y & 0xffffu);
    let drop_a = abs(best.means.x - best.means.y);
    let drop_b = abs(best.means.y - best.means.z);
    let nothing = drop_a + drop_b == 0.0;
    let per_both = 1.0 / select(drop_a + drop_b, 1.0, nothing);
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
    // The first of two overlapping ramps may end last.
    let last = max(end_a, end_b);
    let length = max(min(min(0.5 * sqrt(spread), half_middle - start_a), last - half_middle), 0.0);
    let start = u32(round(half_middle - length));
    let end = u32(round(half_middle + length));
    return in_order(select((start << 16u) | end, best.spans.y, nothing), best.spans.z);
}

// The span, moved to start no later than the node behind it: nodes ascend.
fn in_order(span: u32, next: u32) -> u32 {
    let first = next >> 16u;
    let start = min(span >> 16u, first);
    let end = span & 0xffffu;
    return (start << 16u) | select(end, min(end, next & 0xffffu), start == first);
}
