// Nodes of an invocation's texels, to and from maps and segments. CPU reference:
// crates/gobo-reference/src/curve/mod.rs, `unpack`, crates/gobo-reference/src/curve/format.rs. Rust:
// src/stage/curve.rs, `partial_bytes`.

import package::curve::lights::{Lights, black, scaled, white};
import package::curve::list::{coded, light_behind};
import package::curve::node::{DEPTHS, EVEN, LEAST, LEVELS, OCTAVE, grows};
import package::features::{HAS_OVER, HAS_VOLUMES, NODES, unrolled};
import package::sums::sums::BLACK;
import choice::nodes::{node_at, node_count, set_node};
import choice::rows::{RowBits, RowIs, Rows, row_bits};

// Record of a long tile's segment in `partials`, texel by texel: its filter and nearest depth, then
// `CHANGE_WORDS` if hits add light or volumes absorb, then its nodes, two at a time.

const CHANGE_WORDS: u32 = 7u; // scale; surface scale, last face; surface light; density; crossed; `Unentered`

fn first_node() -> u32 {
    return 1u + select(0u, CHANGE_WORDS, HAS_OVER || HAS_VOLUMES);
}

fn partial_size() -> u32 {
    return first_node() + NODES / 2u;
}

// A node of an invocation's texels, from a map or a segment.
struct LoadedNode {
    start: RowBits, // in fixed point; 0 for an unused node
    end: RowBits,
    passed: Lights,
}

fn loaded_channel(bits: RowBits) -> Rows {
    let level_bits = bits & RowBits(0xfffu);
    if grows() {
        return select(exp2((Rows(level_bits) - EVEN) / OCTAVE), Rows(0.0), level_bits == RowBits(0u));
    }
    return Rows(level_bits) / LEVELS;
}

// `firsts` and `seconds`: the words of each texel's node.
fn loaded_node(firsts: RowBits, seconds: RowBits) -> LoadedNode {
    let root = Rows((firsts >> RowBits(4u)) & RowBits(0xfffu)) / LEVELS;
    let start = firsts >> RowBits(16u);
    let red = ((firsts & RowBits(15u)) << RowBits(8u)) | (seconds >> RowBits(24u));
    return LoadedNode(
        start,
        RowBits(min(round(Rows(start) + root * root * DEPTHS), Rows(DEPTHS))),
        Lights(loaded_channel(red), loaded_channel(seconds >> RowBits(12u)), loaded_channel(seconds)),
    );
}

// Nodes in the format of a map.

// Light behind the stored nodes: what rounding took from one, the next gives back.
var<private> left: Lights;

// Call it before the nodes are stored, in order. Where a late hit brightened the light behind it, the nodes
// before it are too dark; where light grows from black, they keep the least light that can grow.
fn begin_stored() {
    left = white();
    if !(grows() || HAS_VOLUMES) {
        return;
    }
    let least = select(1.0, LEAST, grows());
    var rest = black(); // the most light behind a node
    for (var n = 0u; n < unrolled(node_count); n += 1u) {
        let i = node_count - 1u - n;
        let node = node_at(i);
        let own = light_behind(node);
        let light = Lights(
            storable(own.red, rest.red * least),
            storable(own.green, rest.green * least),
            storable(own.blue, rest.blue * least),
        );
        set_node(i, coded(node.span, light));
        rest = Lights(max(rest.red, light.red), max(rest.green, light.green), max(rest.blue, light.blue));
    }
}

fn storable(light: Rows, least: Rows) -> Rows {
    return max(select(light, Rows(0.0), light < Rows(BLACK)), least);
}

fn stored_channel(light: Rows, before: Rows, used: RowIs) -> RowBits {
    let passed = light / max(before, Rows(1e-9));
    if grows() {
        let level = log2(select(Rows(1.0), max(passed, Rows(1e-9)), used)) * OCTAVE + EVEN;
        let bits = RowBits(round(clamp(level, Rows(1.0), Rows(LEVELS))));
        return select(bits, RowBits(0u), used & (passed <= Rows(0.0)));
    }
    let seen = select(min(passed, Rows(1.0)), Rows(0.0), light < Rows(BLACK));
    return RowBits(round(select(Rows(1.0), seen, used) * LEVELS));
}

struct StoredNode {
    first: RowBits, // words
    second: RowBits,
}

fn stored_node(i: u32) -> StoredNode {
    let node = node_at(i);
    let start = node.span >> RowBits(16u);
    let end = max(node.span & RowBits(0xffffu), start);
    let length = RowBits(round(sqrt(Rows(end - start) / DEPTHS) * LEVELS));
    let light = light_behind(node);
    let used = node.span != RowBits(0u);
    let red = stored_channel(light.red, left.red, used);
    let green = stored_channel(light.green, left.green, used);
    let blue = stored_channel(light.blue, left.blue, used);
    left = scaled(left, Lights(loaded_channel(red), loaded_channel(green), loaded_channel(blue)));
    return StoredNode(
        (start << RowBits(16u)) | (length << RowBits(4u)) | (red >> RowBits(8u)),
        ((red & RowBits(255u)) << RowBits(24u)) | (green << RowBits(12u)) | blue,
    );
}

// Two consecutive nodes, at row `i`.
fn stored_pair(a: StoredNode, b: StoredNode, i: u32) -> vec4<u32> {
    return vec4(row_bits(a.first, i), row_bits(a.second, i), row_bits(b.first, i), row_bits(b.second, i));
}
