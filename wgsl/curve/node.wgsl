// Format of a curve in a map: nodes of 8 bytes. Start (16 bits), square root of the length (12), red, green
// and blue that the node alone passes (12 each). Light at a depth is the product of the nodes. A node that
// starts at 0 is unused, and passes all light, whatever its other bits are. CPU reference: `light_at` in
// src/records/curve.rs, crates/gobo-reference/src/curve/format.rs.

import package::features::{HAS_BRICKS, HAS_GAIN, HAS_OVER, HAS_VOLUMES, NODES};
import package::sums::sums::BLACK;

const DEPTHS: f32 = 65535.0;
const LEVELS: f32 = 4095.0;
// Levels of nodes that may amplify: that of 1, and the number in an octave.
const EVEN: f32 = 2048.0;
const OCTAVE: f32 = 204.8;
// Least light that such a node can pass.
const LEAST: f32 = 0.0009765625;

// Whether light may grow along a ray. Look-ups have `HAS_GAIN` for both features.
fn grows() -> bool {
    return HAS_GAIN || HAS_OVER;
}

// Layer of a pair of nodes where curves have no pages.
fn curve_layer(view_layer: u32, pair: u32) -> u32 {
    return view_layer * (NODES / 2u) + pair;
}

// Node `k` of a curve, out of the pair of nodes in its texel.
fn node_of_pair(pair: vec4<u32>, k: u32) -> vec2<u32> {
    return select(pair.xy, pair.zw, (k & 1u) != 0u);
}

// Number of nodes of a curve up to the last used one of a pair; 0 if the pair is unused.
fn used_nodes(nodes: vec4<u32>, pair: u32) -> u32 {
    let first = select(0u, 2u * pair + 1u, node_start(nodes.xy) > 0.0);
    return select(first, 2u * pair + 2u, node_start(nodes.zw) > 0.0);
}

// Start and length in fixed point.
fn node_start(node: vec2<u32>) -> f32 {
    return f32(node.x >> 16u);
}

fn node_length(node: vec2<u32>) -> f32 {
    let root = f32((node.x >> 4u) & 0xfffu) / LEVELS;
    return root * root * DEPTHS;
}

fn node_bits(node: vec2<u32>) -> vec3<u32> {
    return vec3(((node.x & 15u) << 8u) | (node.y >> 24u), (node.y >> 12u) & 0xfffu, node.y & 0xfffu);
}

// Light that a node passes, of 1 in front of it.
fn node_passed(node: vec2<u32>) -> vec3<f32> {
    let bits = node_bits(node);
    return select(vec3(1.0), passed_of(bits, vec3<f32>(bits) / LEVELS), is_used(node));
}

// Whether a node is used.
fn is_used(node: vec2<u32>) -> bool {
    return node.x >= 0x10000u;
}

fn passed_of(bits: vec3<u32>, share: vec3<f32>) -> vec3<f32> {
    if grows() {
        return select(exp2((vec3<f32>(bits) - EVEN) / OCTAVE), vec3(0.0), bits == vec3(0u));
    }
    return share;
}

// Length and light passed, exact but for the last bit: llvmpipe's compiler does not turn divisions by
// constants into products.
fn quick_length(node: vec2<u32>) -> f32 {
    let root = f32((node.x >> 4u) & 0xfffu);
    return root * root * (DEPTHS / (LEVELS * LEVELS));
}

fn quick_passed(node: vec2<u32>) -> vec3<f32> {
    let bits = node_bits(node);
    return select(vec3(1.0), passed_of(bits, vec3<f32>(bits) * (1.0 / LEVELS)), is_used(node));
}

// Light that a node must pass so that `light` is left of `before`.
fn passed_to(light: vec3<f32>, before: vec3<f32>) -> vec3<f32> {
    let passed = light / max(before, vec3(1e-9));
    if grows() {
        return passed;
    }
    return select(min(passed, vec3(1.0)), vec3(0.0), light < vec3(BLACK));
}

fn stored_passed(passed: vec3<f32>) -> vec3<u32> {
    if grows() {
        let level = log2(max(passed, vec3(1e-9))) * OCTAVE + EVEN;
        return select(vec3(0u), vec3<u32>(round(clamp(level, vec3(1.0), vec3(LEVELS)))), passed > vec3(0.0));
    }
    return vec3<u32>(round(passed * LEVELS));
}

fn packed_node(start: u32, length: f32, passed: vec3<f32>) -> vec2<u32> {
    let root = u32(round(sqrt(length / DEPTHS) * LEVELS));
    let bits = stored_passed(passed);
    return vec2(
        (start << 16u) | (root << 4u) | (bits.r >> 8u),
        ((bits.r & 255u) << 24u) | (bits.g << 12u) | bits.b,
    );
}

const CURVE_SEGMENT: u32 = 8192u;
const ORDERED_SEGMENT: u32 = 4096u; // with `over` or volumes
const BRICK_SEGMENT: u32 = 512u; // with bricks

// Pairs of a segment of a long tile. Rust: `segment_length` in src/shadows/batch/list_plan.rs.
fn curve_segment() -> u32 {
    return select(select(CURVE_SEGMENT, ORDERED_SEGMENT, HAS_OVER || HAS_VOLUMES), BRICK_SEGMENT, HAS_BRICKS);
}
