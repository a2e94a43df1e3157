// Nodes in the format of a map. CPU reference: src/reference/curve/mod.rs.

import package::curve::light4::decode;
import package::curve::list::{node_lights, node_means, spans};
import package::curve::node::{DARKEST_LOG, DEPTHS, LEVELS, OCTAVES};
import package::features::HAS_GAIN;
import package::sums::sums::BLACK;

fn stored_channel(v: vec4<f32>) -> vec4<u32> {
    if HAS_GAIN {
        let octave = (log2(max(v, vec4(1e-9))) - DARKEST_LOG) / OCTAVES;
        return vec4<u32>(round(clamp(octave * LEVELS, vec4(0.0), vec4(LEVELS))));
    }
    return vec4<u32>(round(select(v, vec4(0.0), v < vec4(BLACK)) * LEVELS));
}

// Node i of the four texels in the format of a map: the first words, then the second.
fn packed_first(i: u32) -> vec4<u32> {
    let start = spans[i] >> vec4(16u);
    let end = max(spans[i] & vec4(0xffffu), start);
    let length = vec4<u32>(round(sqrt(vec4<f32>(end - start) / DEPTHS) * LEVELS));
    let red = stored_channel(decode(node_lights[i] & vec4(0xffffu)));
    return (start << vec4(16u)) | (length << vec4(4u)) | (red >> vec4(8u));
}

fn packed_second(i: u32) -> vec4<u32> {
    let red = stored_channel(decode(node_lights[i] & vec4(0xffffu)));
    let green = stored_channel(decode(node_lights[i] >> vec4(16u)));
    let blue = stored_channel(decode(node_means[i] & vec4(0xffffu)));
    return ((red & vec4(255u)) << vec4(24u)) | (green << vec4(12u)) | blue;
}

// Two nodes of the four texels.
struct Packed {
    firsts: array<vec4<u32>, 2>,
    seconds: array<vec4<u32>, 2>,
}

fn packed_pair(pair: u32) -> Packed {
    let i = 2u * pair;
    return Packed(
        array(packed_first(i), packed_first(i + 1u)),
        array(packed_second(i), packed_second(i + 1u)),
    );
}

fn packed_row(nodes: Packed, row: u32) -> vec4<u32> {
    return vec4(nodes.firsts[0][row], nodes.seconds[0][row], nodes.firsts[1][row], nodes.seconds[1][row]);
}
