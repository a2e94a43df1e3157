// Bodies in curves: puffs, and stretches of volumes, in which light falls exponentially. Ramps are linear, so
// while a curve has a free node, the ramp that bends most is split in two, with the exact light in its
// middle. CPU reference: crates/gobo-reference/src/curve/bodies.rs.

import package::curve::lights::{Lights, difference, scaled, selected, white};
import package::curve::list::{coded, light_behind, selected_node};
import package::curve::merge::Merge;
import package::features::{HAS_OVER, HAS_PUFFS, HAS_SOFTENING, HAS_VOLUMES, NODES, unrolled};
import choice::nodes::{node_at, node_count, set_node};
import choice::rows::{RowBits, RowIs, Rows, any_row};

// Least difference between the square roots of the light in front of a body and behind it for which it is
// split: in its middle, the line is off by half the square of that difference.
const MIN_BEND: f32 = 0.0625;
const SHORTEST: u32 = 4u; // shortest ramp that is split, in fixed point
const MIN_ROOT: f32 = 0.022097087; // least root of light: black counts as 1/2048

var<private> alone: RowBits;     // bit i: node i is a single hit, not merged
var<private> new_index: RowBits; // index of the inserted node

// The ramp that deviates most from the exponential.
struct Bent {
    bend: Rows,
    index: RowBits,
    light: Lights, // in the ramp's middle
}

// Whether any ramp may be a body. With `over`, light may grow inside one.
fn has_bodies() -> bool {
    return (HAS_PUFFS || HAS_VOLUMES) && !HAS_OVER;
}

fn clear_bodies() {
    alone = RowBits(0u);
    new_index = RowBits(0u);
}

fn below(i: RowBits) -> RowBits {
    return (RowBits(1u) << i) - 1u;
}

fn has_bit(bits: RowBits, i: RowBits) -> RowIs {
    return ((bits >> i) & RowBits(1u)) == RowBits(1u);
}

// Updates `alone` after an insertion at `new_index`. Where the node fits, the first one was free.
fn follow_insertion(counts: RowIs, fits: RowIs) {
    if !has_bodies() {
        return;
    }
    let front = below(new_index);
    let open = (alone & front) | ((alone & ~front) << RowBits(1u)) | (RowBits(1u) << new_index);
    alone = select(select(alone, open, counts), open >> RowBits(1u), fits);
}

// Updates `alone` after the merge `best`.
fn follow_merge(best: Merge, counts: RowIs) {
    if !has_bodies() {
        return;
    }
    // A node that absorbs nothing leaves the other as it is.
    let second = (best.between == best.behind) & has_bit(alone, best.index);
    let kept = select(second, has_bit(alone, best.index + 1u), best.before == best.between);
    let merged = select(RowBits(0u), RowBits(1u) << best.index, kept);
    let behind = (alone >> RowBits(1u)) & ~below(best.index + 1u);
    alone = select(alone, (alone & below(best.index)) | merged | behind, counts);
}

// Splits bodies while nodes are free, but for one that softening needs.
fn split_bodies() {
    if !has_bodies() {
        return;
    }
    loop {
        let most = most_bent();
        let free = node_at(select(0u, 1u, HAS_SOFTENING)).span == RowBits(0u);
        let is = free & (most.bend > Rows(MIN_BEND));
        halve(most, is);
        if !any_row(is) {
            break;
        }
    }
}

fn middle_of(span: RowBits) -> RowBits {
    return ((span >> RowBits(16u)) + (span & RowBits(0xffffu)) + 1u) >> RowBits(1u);
}

fn root(light: Lights) -> Lights {
    return Lights(sqrt(light.red), sqrt(light.green), sqrt(light.blue));
}

fn most_bent() -> Bent {
    var most = Bent(Rows(0.0), RowBits(0u), white());
    var before = white();
    for (var i = 0u; i < unrolled(node_count); i += 1u) {
        let node = node_at(i);
        let root_behind = root(light_behind(node));
        let bend = difference(before, root_behind);
        // No other ramp may start in its front half.
        let next = select(node_at(i + 1u).span >> RowBits(16u), RowBits(0xffffu), RowIs(i + 1u == NODES));
        let long = (node.span & RowBits(0xffffu)) >= (node.span >> RowBits(16u)) + SHORTEST;
        let single = has_bit(alone, RowBits(i));
        let is = long & single & (next >= middle_of(node.span)) & (bend > most.bend);
        let least = Rows(MIN_ROOT);
        let behind = Lights(
            max(root_behind.red, least),
            max(root_behind.green, least),
            max(root_behind.blue, least),
        );
        most = Bent(
            select(most.bend, bend, is),
            select(most.index, RowBits(i), is),
            selected(most.light, scaled(before, behind), is),
        );
        before = root_behind;
    }
    return most;
}

// Moves the nodes in front of the split ramp into the free node; its two halves follow.
fn halve(most: Bent, is: RowIs) {
    let half = coded(RowBits(0u), most.light);
    for (var i = 0u; i < unrolled(node_count); i += 1u) {
        let node = node_at(i);
        let next = node_at(i + 1u);
        let moves = is & (RowBits(i + 1u) < most.index);
        let first = is & (RowBits(i + 1u) == most.index);
        let second = is & (RowBits(i) == most.index);
        let whole = select(node.span, next.span, first | moves);
        let middle = middle_of(whole);
        let near = (whole & RowBits(0xffff0000u)) | middle;
        let far = (middle << RowBits(16u)) | (whole & RowBits(0xffffu));
        var moved = selected_node(selected_node(node, half, first), next, moves);
        moved.span = select(select(whole, near, first), far, second);
        set_node(i, moved);
    }
    let front = below(most.index);
    let moved =
        (alone & ~front) | ((alone & front) >> RowBits(1u)) | ((front + 1u) >> RowBits(1u));
    alone = select(alone, moved, is);
}
