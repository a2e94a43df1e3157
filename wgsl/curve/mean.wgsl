// Mean of several curves in a few nodes: each node joins the ramps between two of the longest gaps in depth.
// CPU reference: crates/gobo-reference/src/curve/mean.rs.

import package::curve::node::{
    DEPTHS, LEAST, grows, node_length, node_passed, node_start, packed_node, passed_to,
};
import choice::below::{child_ramp, child_share, start_child};

// A ramp: a depth range over which light falls linearly.
struct Ramp {
    start: f32,      // in fixed point; 0 for an unused one
    length: f32,
    drop: vec3<f32>,
}

const BINS: u32 = 32u; // bins of the depths, between which gaps are found

var<private> part_low: u32;  // twice the middle of the first ramp, and of the last
var<private> part_high: u32;
var<private> per_range: f32;
var<private> part_cuts: u32; // first bins of the further parts
var<private> part_count: u32; // parts that hold ramps
var<private> part_light: vec3<f32>; // mean light behind the parts so far
var<private> part_stored: vec3<f32>; // the same light as the stored nodes give it, which are rounded

var<private> light_before: vec3<f32>; // light behind a child's ramps so far

// Ramp of a child's next node.
fn next_ramp(node: vec2<u32>) -> Ramp {
    let start = node_start(node);
    let light = light_before * node_passed(node);
    let drop = light_before - light;
    light_before = select(light_before, light, start > 0.0);
    return Ramp(start, node_length(node), drop);
}

fn ramp_weight(ramp: Ramp) -> f32 {
    return select(0.0, abs(ramp.drop.x) + abs(ramp.drop.y) + abs(ramp.drop.z), ramp.start > 0.0);
}

// Twice the middle of the ramp.
fn ramp_middle(ramp: Ramp) -> u32 {
    return 2u * u32(ramp.start) + u32(round(ramp.length));
}

// An exact integer quotient, corrected from floats: llvmpipe divides integers one by one.
fn ramp_bin(ramp: Ramp) -> u32 {
    let above = (ramp_middle(ramp) - part_low) * BINS;
    let range = part_high - part_low + 1u;
    let near = u32(f32(above) * per_range);
    let least = near - select(0u, 1u, near * range > above);
    return least + select(0u, 1u, (least + 1u) * range <= above);
}

// Finds the parts, at most `parts`. Every child has ramps: the loops test at their end, because llvmpipe runs
// a body once more where the test comes first.
fn find_parts(children: u32, ramps: u32, parts: u32) {
    part_light = vec3(1.0);
    part_stored = vec3(1.0);
    part_low = 0xffffffffu;
    part_high = 0u;
    for (var i = 0u; i < children; i += 1u) {
        start_child(i);
        var k = 0u;
        loop {
            let ramp = child_ramp(k);
            let counts = ramp_weight(ramp) > 0.0;
            part_low = select(part_low, min(part_low, ramp_middle(ramp)), counts);
            part_high = select(part_high, max(part_high, ramp_middle(ramp)), counts);
            k += 1u;
            if k >= ramps {
                break;
            }
        }
    }
    per_range = 1.0 / f32(part_high - part_low + 1u);
    // A single bin has no gaps.
    let again = select(0u, children, part_low < part_high);
    var mask = 0u;
    for (var i = 0u; i < again; i += 1u) {
        start_child(i);
        var k = 0u;
        loop {
            let ramp = child_ramp(k);
            let counts = ramp_weight(ramp) > 0.0;
            mask |= select(0u, 1u << (ramp_bin(ramp) & 31u), counts);
            k += 1u;
            if k >= ramps {
                break;
            }
        }
    }
    part_cuts = longest_gaps(mask, parts - 1u);
    part_count = countOneBits(part_cuts) + select(0u, 1u, part_low <= part_high);
}

// Mask of the bins behind the `most` longest gaps; of equal gaps, the first.
fn longest_gaps(mask: u32, most: u32) -> u32 {
    var near = 0u; // bins within that distance behind a bin with ramps
    var cuts = mask & (mask - 1u); // bins behind gaps at least as long
    var longer = cuts;
    for (var gap = 1u; gap < BINS && countOneBits(longer) > most; gap += 1u) {
        cuts = longer;
        near |= mask << gap;
        longer = cuts & ~near;
    }
    var equal = cuts & ~longer;
    while equal != 0u && countOneBits(longer) < most {
        longer |= equal & (~equal + 1u);
        equal &= equal - 1u;
    }
    return longer;
}

// Node of part `number`; parts must be asked for in order.
fn part_node(number: u32, children: u32, ramps: u32) -> vec2<u32> {
    var weight = 0.0;
    var sum = 0.0;
    var square = 0.0;
    var first = DEPTHS;
    var end = 0.0;
    var middle = 0.0;
    let holders = select(0u, children, number < part_count);
    for (var i = 0u; i < holders; i += 1u) {
        start_child(i);
        var k = 0u;
        loop {
            let ramp = child_ramp(k);
            let below = (2u << (ramp_bin(ramp) & 31u)) - 1u;
            let is_cut = countOneBits(part_cuts & below) == number;
            let drop = select(0.0, ramp_weight(ramp) * child_share(), is_cut);
            let counts = drop > 0.0;
            let ramp_middle = ramp.start + 0.5 * ramp.length;
            middle = select(middle, ramp_middle, counts && weight == 0.0);
            let off = ramp_middle - middle;
            weight += drop;
            sum += drop * off;
            square += drop * (off * off + ramp.length * ramp.length * (1.0 / 12.0));
            first = select(first, min(first, ramp.start), counts);
            end = select(end, max(end, ramp.start + ramp.length), counts);
            part_light -= select(vec3(0.0), ramp.drop * child_share(), counts);
            k += 1u;
            if k >= ramps {
                break;
            }
        }
    }
    let off = sum / max(weight, 1e-30);
    let spread = max(square / max(weight, 1e-30) - off * off, 0.0);
    let mean = middle + off;
    let half = max(min(sqrt(3.0 * spread), min(mean - first, end - mean)), 0.0);
    let is = weight > 0.0;
    let start = select(0u, clamp(u32(round(max(mean - half, 0.0))), 1u, 65535u), is);
    let length = select(0.0, 2.0 * half, is);
    let light = max(part_light, vec3(select(0.0, LEAST, grows())));
    let node = packed_node(start, length, select(vec3(1.0), passed_to(light, part_stored), is));
    part_stored *= node_passed(node);
    return node;
}
