// Bodies in the curves of four texels: puffs, and stretches of volumes, in which light falls exponentially.
// Ramps are linear, so while a curve has a free node, its ramp that bends most becomes two, with the light
// in the middle right. CPU reference: src/reference/curve/bodies.rs.

import package::curve::light4::{
    Light4, decode_light, encode_lights, encode_means, plus, root4, scaled, selected, white4,
};
import package::curve::list::{node_lights, node_means, spans};
import package::curve::merge::{best, best_before, best_means};
import package::features::{HAS_OVER, HAS_PUFFS, HAS_SOFTENING, HAS_VOLUMES, NODES};

// Least difference between the square roots of the light in front of a body and behind it at which it is
// worth two nodes: in its middle, the line is off by half of its square.
const MIN_BEND: f32 = 0.0625;
const SHORTEST: u32 = 4u; // ramp that becomes two, in fixed point
const MIN_ROOT: f32 = 0.022097087; // of light: black counts as 1/2048

var<private> alone: vec4<u32>;     // bit i: node i is a single hit, not merged
var<private> new_place: vec4<u32>; // index of the inserted node
// The ramp that bends most so far.
var<private> bend: vec4<f32>;
var<private> bent: vec4<u32>;
var<private> bent_light: Light4; // in its middle
var<private> root_before: Light4;

// Whether any ramp may be a body. With `over` light may grow inside one.
fn has_bodies() -> bool {
    return (HAS_PUFFS || HAS_VOLUMES) && !HAS_OVER;
}

fn clear_bodies() {
    alone = vec4(0u);
    new_place = vec4(0u);
}

fn below(i: vec4<u32>) -> vec4<u32> {
    return (vec4(1u) << i) - 1u;
}

// Follows an insertion at `new_place`, and the merge of `best` and the node behind it.
fn follow_merge(counts: vec4<bool>) {
    if !has_bodies() {
        return;
    }
    let front = below(new_place);
    let open = (alone & front) | ((alone & ~front) << vec4(1u)) | (vec4(1u) << new_place);
    // One that absorbs nothing leaves the other as it is.
    let own = open >> best;
    let second = (best_means[0] == best_means[1]) & ((own & vec4(1u)) == vec4(1u));
    let kept = select(second, (own & vec4(2u)) == vec4(2u), best_before == best_means[0]);
    let merged = select(vec4(0u), vec4(1u) << best, kept);
    let shut = (open & below(best)) | merged | ((open >> vec4(1u)) & ~below(best + 1u));
    alone = select(alone, shut, counts);
}

// Splits bodies while nodes are free; one is left for a ramp of the softening.
fn split_bodies() {
    if !has_bodies() {
        return;
    }
    loop {
        find_bent();
        let free = select(spans[0], spans[1], HAS_SOFTENING) == vec4(0u);
        let is = free & (bend > vec4(MIN_BEND));
        halve_bent(is);
        if !any(is) {
            break;
        }
    }
}

fn find_bent() {
    bend = vec4(0.0);
    bent = vec4(0u);
    bent_light = white4();
    root_before = white4();
    compare(0u);
    compare(1u);
    compare(2u);
    compare(3u);
    if NODES > 4u {
        compare(4u);
        compare(5u);
        compare(6u);
        compare(7u);
    }
    if NODES > 8u {
        compare(8u);
        compare(9u);
        compare(10u);
        compare(11u);
        compare(12u);
        compare(13u);
        compare(14u);
        compare(15u);
    }
}

fn middle_of(span: vec4<u32>) -> vec4<u32> {
    return ((span >> vec4(16u)) + (span & vec4(0xffffu)) + 1u) >> vec4(1u);
}

fn compare(i: u32) {
    let own = root4(decode_light(node_lights[i], node_means[i]));
    let apart = plus(root_before, scaled(own, Light4(vec4(-1.0), vec4(-1.0), vec4(-1.0))));
    let most = max(max(abs(apart.red), abs(apart.green)), abs(apart.blue));
    // No ramp may start in the front half.
    let next = select(spans[i + 1u] >> vec4(16u), vec4(0xffffu), i + 1u == NODES);
    let long = (spans[i] & vec4(0xffffu)) >= (spans[i] >> vec4(16u)) + SHORTEST;
    let single = ((alone >> vec4(i)) & vec4(1u)) == vec4(1u);
    let is = long & single & (next >= middle_of(spans[i])) & (most > bend);
    let least = vec4(MIN_ROOT);
    let behind = Light4(max(own.red, least), max(own.green, least), max(own.blue, least));
    bend = select(bend, most, is);
    bent = select(bent, vec4(i), is);
    bent_light = selected(bent_light, scaled(root_before, behind), is);
    root_before = own;
}

// Moves what is in front of the bent ramp into the free node; the two halves follow.
fn halve_bent(is: vec4<bool>) {
    let light = encode_lights(bent_light);
    let mean = encode_means(bent_light);
    halve(0u, is, light, mean);
    halve(1u, is, light, mean);
    halve(2u, is, light, mean);
    halve(3u, is, light, mean);
    if NODES > 4u {
        halve(4u, is, light, mean);
        halve(5u, is, light, mean);
        halve(6u, is, light, mean);
        halve(7u, is, light, mean);
    }
    if NODES > 8u {
        halve(8u, is, light, mean);
        halve(9u, is, light, mean);
        halve(10u, is, light, mean);
        halve(11u, is, light, mean);
        halve(12u, is, light, mean);
        halve(13u, is, light, mean);
        halve(14u, is, light, mean);
        halve(15u, is, light, mean);
    }
    let front = below(bent);
    let moved = (alone & ~front) | ((alone & front) >> vec4(1u)) | ((front + 1u) >> vec4(1u));
    alone = select(alone, moved, is);
}

fn halve(i: u32, is: vec4<bool>, light: vec4<u32>, mean: vec4<u32>) {
    let moves = is & (vec4(i + 1u) < bent);
    let first = is & (vec4(i + 1u) == bent);
    let second = is & (vec4(i) == bent);
    let whole = select(spans[i], spans[i + 1u], first | moves);
    let middle = middle_of(whole);
    let near = (whole & vec4(0xffff0000u)) | middle;
    let far = (middle << vec4(16u)) | (whole & vec4(0xffffu));
    spans[i] = select(select(whole, near, first), far, second);
    node_lights[i] = select(select(node_lights[i], light, first), node_lights[i + 1u], moves);
    node_means[i] = select(select(node_means[i], mean, first), node_means[i + 1u], moves);
}
