// The cheapest merge of two neighbours among the nodes of a curve. CPU reference:
// crates/gobo-reference/src/curve/mod.rs.

import package::curve::lights::level;
import package::features::{HAS_GAIN, NODES, unrolled};
import choice::nodes::{node_at, node_count};
import choice::rows::{RowBits, RowIs, Rows};

struct Merge {
    cost: Rows,
    index: RowBits,  // of the pair's first node
    before: Rows,    // mean light in front of the pair, behind its first node, and behind both
    between: Rows,
    behind: Rows,
    first: RowBits,  // spans
    second: RowBits,
    next: RowBits,   // span of the node behind the pair
}

// Cost of a merge: the area between the curve and the straight line over both ramps; 0 if one of them absorbs
// nothing.
fn cheapest_merge() -> Merge {
    var best = Merge(
        Rows(1e38), RowBits(0u), Rows(0.0), Rows(0.0), Rows(0.0), RowBits(0u), RowBits(0u), RowBits(0u),
    );
    var before = Rows(select(65535.0, 1.0, HAS_GAIN));
    var a = node_at(0u);
    for (var i = 0u; i < unrolled(node_count); i += 1u) {
        let b = node_at(i + 1u);
        let between = level(a.means >> RowBits(16u));
        let behind = level(b.means >> RowBits(16u));
        let first = before - between;
        let second = between - behind;
        let start = Rows(a.span >> RowBits(16u));
        let first_area = first * (Rows(b.span & RowBits(0xffffu)) - start);
        let both = first + second;
        let cost = select(
            abs(first_area - both * (Rows(a.span & RowBits(0xffffu)) - start))
                + abs(first_area - both * (Rows(b.span >> RowBits(16u)) - start)),
            Rows(0.0),
            first * second == Rows(0.0),
        );
        let better = cost < best.cost;
        best.cost = select(best.cost, cost, better);
        best.index = select(best.index, RowBits(i), better);
        best.before = select(best.before, before, better);
        best.between = select(best.between, between, better);
        best.behind = select(best.behind, behind, better);
        best.first = select(best.first, a.span, better);
        best.second = select(best.second, b.span, better);
        let next = select(node_at(min(i + 2u, NODES)).span, RowBits(0xffffffffu), RowIs(i + 1u == NODES));
        best.next = select(best.next, next, better);
        before = between;
        a = b;
    }
    return best;
}

// Span of a ramp with the mean and variance of both ramps, clamped to their joint span.
fn merged_span(best: Merge) -> RowBits {
    let start_a = Rows(best.first >> RowBits(16u));
    let end_a = Rows(best.first & RowBits(0xffffu));
    let start_b = Rows(best.second >> RowBits(16u));
    let end_b = Rows(best.second & RowBits(0xffffu));
    let drop_a = abs(best.before - best.between);
    let drop_b = abs(best.between - best.behind);
    let nothing = drop_a + drop_b == Rows(0.0);
    let per_both = 1.0 / select(drop_a + drop_b, Rows(1.0), nothing);
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
    let length = max(min(min(0.5 * sqrt(spread), half_middle - start_a), last - half_middle), Rows(0.0));
    let start = RowBits(round(half_middle - length));
    let end = RowBits(round(half_middle + length));
    let span = select((start << RowBits(16u)) | end, best.second, nothing);
    return in_order(span, best.next);
}

// The span, moved to start no later than the node behind it: nodes ascend.
fn in_order(span: RowBits, next: RowBits) -> RowBits {
    let first = next >> RowBits(16u);
    let start = min(span >> RowBits(16u), first);
    let end = span & RowBits(0xffffu);
    return (start << RowBits(16u)) | select(end, min(end, next & RowBits(0xffffu)), start == first);
}
