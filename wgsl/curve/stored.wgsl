// Nodes in the format of a map. CPU reference: src/reference/curve/mod.rs.

import package::curve::list::light_behind;
import package::curve::node::{DARKEST_LOG, DEPTHS, LEVELS, OCTAVES};
import package::features::HAS_GAIN;
import package::sums::sums::BLACK;
import choice::nodes::node_at;
import choice::rows::{RowBits, Rows, row_bits};

fn stored_channel(v: Rows) -> RowBits {
    if HAS_GAIN {
        let octave = (log2(max(v, Rows(1e-9))) - DARKEST_LOG) / OCTAVES;
        return RowBits(round(clamp(octave * LEVELS, Rows(0.0), Rows(LEVELS))));
    }
    return RowBits(round(select(v, Rows(0.0), v < Rows(BLACK)) * LEVELS));
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
    let red = stored_channel(light.red);
    return StoredNode(
        (start << RowBits(16u)) | (length << RowBits(4u)) | (red >> RowBits(8u)),
        ((red & RowBits(255u)) << RowBits(24u)) | (stored_channel(light.green) << RowBits(12u))
            | stored_channel(light.blue),
    );
}

// A row of two nodes that follow each other.
fn stored_pair(a: StoredNode, b: StoredNode, i: u32) -> vec4<u32> {
    return vec4(row_bits(a.first, i), row_bits(a.second, i), row_bits(b.first, i), row_bits(b.second, i));
}
