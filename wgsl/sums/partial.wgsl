// Transfer of a segment to the light of one texel, which `resolve` composes in order: L becomes L * scale +
// added. CPU reference: crates/gobo-reference/src/accumulate.rs, `Passed`.

import package::features::HAS_GAIN;
import package::traversal::lane::sum_index;

struct Partial {
    scale: vec3<f32>,
    added: vec3<f32>,
    nearest: f32,
    tau: vec3<i32>, // of volumes, modulo 2^32
    leaves: i32,    // volumes that the ray leaves, minus those that it enters
    owner: u32,
}

const PARTIAL_TEXELS: u32 = 2u; // of `partials`; Rust: src/shadows/batch/scratch.rs

// A half has the range that `gain` needs, but only 11 bits.
fn pack_pair(v: vec2<f32>) -> u32 {
    if HAS_GAIN {
        return pack2x16float(min(v, vec2(65504.0)));
    }
    return pack2x16unorm(v);
}

fn unpack_pair(bits: u32) -> vec2<f32> {
    if HAS_GAIN {
        return unpack2x16float(bits);
    }
    return unpack2x16unorm(bits);
}

fn pack_partial(p: Partial) -> vec4<u32> {
    return vec4(
        pack_pair(p.scale.rg),
        pack_pair(vec2(p.scale.b, p.added.r)),
        pack_pair(p.added.gb),
        bitcast<u32>(p.nearest),
    );
}

// Number of segments that fit in `length` texels of `partials`.
fn partial_capacity(length: u32) -> u32 {
    return length / (PARTIAL_TEXELS * sum_index(1u, vec2(0u)));
}
