// A node of four texels, from a map or a segment. CPU reference: src/reference/curve/mod.rs, `unpack`.

import package::curve::light4::Light4;
import package::curve::node::{DARKEST_LOG, DEPTHS, LEVELS, OCTAVES};
import package::features::HAS_GAIN;

struct LoadedNode {
    start: vec4<u32>, // in fixed point; 0 for an unused node
    end: vec4<u32>,
    light: Light4,    // behind
}

fn loaded_channel(bits: vec4<u32>) -> vec4<f32> {
    let share = vec4<f32>(bits & vec4(0xfffu)) / LEVELS;
    if HAS_GAIN {
        return select(exp2(share * OCTAVES + DARKEST_LOG), vec4(0.0), (bits & vec4(0xfffu)) == vec4(0u));
    }
    return share;
}

// `firsts` and `seconds`: the words of each texel's node.
fn loaded_node(firsts: vec4<u32>, seconds: vec4<u32>) -> LoadedNode {
    let root = vec4<f32>((firsts >> vec4(4u)) & vec4(0xfffu)) / LEVELS;
    let start = firsts >> vec4(16u);
    return LoadedNode(
        start,
        vec4<u32>(min(round(vec4<f32>(start) + root * root * DEPTHS), vec4(DEPTHS))),
        Light4(
            loaded_channel(((firsts & vec4(15u)) << vec4(8u)) | (seconds >> vec4(24u))),
            loaded_channel(seconds >> vec4(12u)),
            loaded_channel(seconds),
        ),
    );
}
