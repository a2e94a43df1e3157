// Format of a curve in a map: nodes of 8 bytes, nearest first. CPU reference: src/reference/curve/mod.rs. Start
// (16 bits), square root of the length (12), red, green, blue behind (12 each). A node that starts at 0 is
// unused.

import package::features::{HAS_BRICKS, HAS_GAIN, HAS_OVER, HAS_VOLUMES, NODES};
import package::sums::sums::BLACK;

const DEPTHS: f32 = 65535.0;
const LEVELS: f32 = 4095.0;
// Octaves of a curve with `gain`.
const OCTAVES: f32 = 20.0;
const DARKEST_LOG: f32 = -10.0;

fn curve_layer(view_layer: u32, pair: u32) -> u32 {
    return view_layer * (NODES / 2u) + pair;
}

// Node `k` of a curve, out of the pair of nodes in its texel.
fn node_of_pair(pair: vec4<u32>, k: u32) -> vec2<u32> {
    return select(pair.xy, pair.zw, (k & 1u) != 0u);
}

// Nodes of a curve up to the last used one of a pair; 0 if it has none.
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

fn node_light(node: vec2<u32>) -> vec3<f32> {
    let bits = node_bits(node);
    return light_of(bits, vec3<f32>(bits) / LEVELS);
}

fn light_of(bits: vec3<u32>, share: vec3<f32>) -> vec3<f32> {
    if HAS_GAIN {
        return select(exp2(share * OCTAVES + DARKEST_LOG), vec3(0.0), bits == vec3(0u));
    }
    return share;
}

// Length and light but for their last bit: compilers of llvmpipe keep divisions by constants.
fn quick_length(node: vec2<u32>) -> f32 {
    let root = f32((node.x >> 4u) & 0xfffu);
    return root * root * (DEPTHS / (LEVELS * LEVELS));
}

fn quick_light(node: vec2<u32>) -> vec3<f32> {
    let bits = node_bits(node);
    return light_of(bits, vec3<f32>(bits) * (1.0 / LEVELS));
}

fn stored_light(light: vec3<f32>) -> vec3<u32> {
    if HAS_GAIN {
        let octave = (log2(max(light, vec3(1e-9))) - DARKEST_LOG) / OCTAVES;
        return vec3<u32>(round(clamp(octave * LEVELS, vec3(0.0), vec3(LEVELS))));
    }
    return vec3<u32>(round(select(light, vec3(0.0), light < vec3(BLACK)) * LEVELS));
}

fn packed_node(start: u32, length: f32, light: vec3<f32>) -> vec2<u32> {
    let root = u32(round(sqrt(length / DEPTHS) * LEVELS));
    let bits = stored_light(light);
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
