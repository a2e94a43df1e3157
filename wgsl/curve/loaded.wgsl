// A node of an invocation's texels, from a map or a segment. CPU reference:
// crates/gobo-reference/src/curve/mod.rs, `unpack`.

import package::curve::lights::Lights;
import package::curve::node::{DEPTHS, EVEN, LEVELS, OCTAVE, grows};
import choice::rows::{RowBits, Rows};

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
