// Bodies in curves: puffs, and stretches of volumes, in which light falls exponentially. Ramps are linear, so
// while a curve has a free node, the ramp that bends most is split in two, with the exact light in its
// middle. CPU reference: crates/gobo-reference/src/curve/bodies.rs.

import package::curve::gather::{ROWS, texels};
import package::curve::list::{coded, light_behind};
import package::curve::merge::Merge;
import package::curve::volumes::largest;
import package::features::{HAS_OVER, HAS_PUFFS, HAS_SOFTENING, HAS_VOLUMES, NODES, unrolled};
import choice::nodes::{node_at, node_count, set_node};

// Least difference between the square roots of the light in front of a body and behind it for which it is
// split: in its middle, the line is off by half the square of that difference.
const MIN_BEND: f32 = 0.0625;
const SHORTEST: u32 = 4u; // shortest ramp that is split, in fixed point
const MIN_ROOT: f32 = 0.022097087; // least root of light: black counts as 1/2048

// The ramp that deviates most from the exponential.
struct Bent {
    bend: f32,
    index: u32,
    light: vec3<f32>, // in the ramp's middle
}

// Whether any ramp may be a body. With `over`, light may grow inside one.
fn has_bodies() -> bool {
    return (HAS_PUFFS || HAS_VOLUMES) && !HAS_OVER;
}

fn below(k: u32) -> u32 {
    return (1u << k) - 1u;
}

fn has_bit(bits: u32, k: u32) -> bool {
    return ((bits >> k) & 1u) == 1u;
}

// `alone` after an insertion at `index`. Where the node fits, the first one was free.
fn follow_insertion(alone: u32, index: u32, counts: bool, fits: bool) -> u32 {
    let front = below(index);
    let open = (alone & front) | ((alone & ~front) << 1u) | (1u << index);
    return select(select(alone, open, counts), open >> 1u, fits);
}

// `alone` after the merge `best`, where `counts` holds.
fn follow_merge(alone: u32, best: Merge, counts: bool) -> u32 {
    // A node that absorbs nothing leaves the other as it is.
    let second = (best.means.y == best.means.z) & has_bit(alone, best.index);
    let kept = select(second, has_bit(alone, best.index + 1u), best.means.x == best.means.y);
    let merged = select(0u, 1u << best.index, kept);
    let behind = (alone >> 1u) & ~below(best.index + 1u);
    return select(alone, (alone & below(best.index)) | merged | behind, counts);
}

// Splits bodies while nodes are free, but for one that softening needs.
fn split_bodies() {
    if !has_bodies() {
        return;
    }
    loop {
        var some = false;
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            let most = most_bent(texels[i].alone, i);
            let free = node_at(i, select(0u, 1u, HAS_SOFTENING)).x == 0u;
            let is = free & (most.bend > MIN_BEND);
            texels[i].alone = halve(texels[i].alone, i, most, is);
            some = some | is;
        }
        if !some {
            break;
        }
    }
}

fn middle_of(span: u32) -> u32 {
    return ((span >> 16u) + (span & 0xffffu) + 1u) >> 1u;
}

fn most_bent(alone: u32, i: u32) -> Bent {
    var most = Bent(0.0, 0u, vec3(1.0));
    var before = vec3(1.0);
    for (var k = 0u; k < unrolled(node_count); k += 1u) {
        let node = node_at(i, k);
        let root_behind = sqrt(light_behind(node));
        let bend = largest(before - root_behind);
        // No other ramp may start in its front half.
        let next = select(node_at(i, k + 1u).x >> 16u, 0xffffu, k + 1u == NODES);
        let long = (node.x & 0xffffu) >= (node.x >> 16u) + SHORTEST;
        let single = has_bit(alone, k);
        let is = long & single & (next >= middle_of(node.x)) & (bend > most.bend);
        let middle = before * max(root_behind, vec3(MIN_ROOT));
        most = Bent(
            select(most.bend, bend, is),
            select(most.index, k, is),
            select(most.light, middle, is),
        );
        before = root_behind;
    }
    return most;
}

// Moves the nodes in front of the split ramp into the free node; its two halves follow. Returns the new
// `alone`.
fn halve(alone: u32, i: u32, most: Bent, is: bool) -> u32 {
    let half = coded(0u, most.light);
    for (var k = 0u; k < unrolled(node_count); k += 1u) {
        let node = node_at(i, k);
        let next = node_at(i, k + 1u);
        let moves = is & (k + 1u < most.index);
        let first = is & (k + 1u == most.index);
        let second = is & (k == most.index);
        let whole = select(node.x, next.x, first | moves);
        let middle = middle_of(whole);
        let near = (whole & 0xffff0000u) | middle;
        let far = (middle << 16u) | (whole & 0xffffu);
        var moved = select(select(node, half, first), next, moves);
        moved.x = select(select(whole, near, first), far, second);
        set_node(i, k, moved);
    }
    let front = below(most.index);
    let moved = (alone & ~front) | ((alone & front) >> 1u) | ((front + 1u) >> 1u);
    return select(alone, moved, is);
}
