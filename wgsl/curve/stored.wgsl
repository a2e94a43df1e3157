// Nodes of a texel's list, in the format of maps and segments. CPU reference:
// crates/gobo-reference/src/curve/mod.rs, crates/gobo-reference/src/curve/format.rs. Rust:
// src/stage/curve.rs, `partial_bytes`.

import package::curve::list::{coded, light_behind};
import package::curve::node::{LEAST, grows, node_passed, packed_node, passed_to};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES, unrolled};
import package::sums::sums::BLACK;
import choice::nodes::{node_at, node_count, set_node};

// Record of a long tile's segment in `partials`, texel by texel: its filter and nearest depth, then
// `CHANGE_WORDS` if hits add light or volumes absorb, then its nodes, two at a time.

const CHANGE_WORDS: u32 = 7u; // scale; surface scale, last face; surface light; density; crossed; `Unentered`

fn first_node() -> u32 {
    return 1u + select(0u, CHANGE_WORDS, HAS_OVER || HAS_VOLUMES);
}

fn partial_size() -> u32 {
    return first_node() + NODES / 2u;
}

// Call it before nodes are stored, in order. Where a late hit brightened the light behind it, the nodes
// before it are too dark; where light grows from black, they keep the least light that can grow.
fn begin_stored(i: u32) {
    if !(grows() || HAS_VOLUMES) {
        return;
    }
    var rest = vec3(0.0); // the most light behind a node
    for (var n = 0u; n < unrolled(node_count); n += 1u) {
        let k = node_count - 1u - n;
        let node = node_at(i, k);
        let own = light_behind(node);
        let seen = select(own, vec3(0.0), own < vec3(BLACK));
        let light = max(seen, rest * select(1.0, LEAST, grows()));
        set_node(i, k, coded(node.x, light));
        rest = max(rest, light);
    }
}

// Node `k`. `left`: light behind the stored nodes, so that the next node gives back what rounding took.
fn stored_node(i: u32, k: u32, left: ptr<function, vec3<f32>>) -> vec2<u32> {
    let node = node_at(i, k);
    let start = node.x >> 16u;
    let end = max(node.x & 0xffffu, start);
    let passed = select(vec3(1.0), passed_to(light_behind(node), *left), node.x != 0u);
    let stored = packed_node(start, f32(end - start), passed);
    *left *= node_passed(stored);
    return stored;
}

// Nodes 2 `pair` and 2 `pair` + 1.
fn stored_pair(i: u32, pair: u32, left: ptr<function, vec3<f32>>) -> vec4<u32> {
    let first = stored_node(i, 2u * pair, left);
    return vec4(first, stored_node(i, 2u * pair + 1u, left));
}
