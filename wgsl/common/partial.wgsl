// What a segment does to the light of one texel, for resolve to compose in order: L becomes
// L * scale + added. CPU twin: src/cpu/accumulate.rs, `Passed`. Needs common/volumes.wgsl, sums.wgsl;
// the kernel binds `partials`.
struct Partial {
    scale: vec3<f32>,
    added: vec3<f32>,
    nearest: f32,
    tau: vec3<i32>, // of volumes, modulo 2^32
    leaves: i32,    // volumes that the ray leaves more than it enters
    owner: u32,
}

const PARTIAL_TEXELS: u32 = 2u; // of `partials`; Rust: src/pipeline/list.rs

// Half a float holds what `gain` brightens, but only 11 bits.
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

fn load_partial(texel: u32) -> Partial {
    let bits = partials[texel * PARTIAL_TEXELS];
    var signed = vec4(0);
    if HAS_VOLUMES || HAS_OWNERS {
        signed = bitcast<vec4<i32>>(partials[texel * PARTIAL_TEXELS + 1u]);
    }
    let middle = unpack_pair(bits.y);
    return Partial(
        vec3(unpack_pair(bits.x), middle.x),
        vec3(middle.y, unpack_pair(bits.z)),
        bitcast<f32>(bits.w),
        signed.xyz,
        (signed.w << 16u) >> 16u,
        bitcast<u32>(signed.w) >> 16u,
    );
}

// Segments that `partials` has room for.
fn partial_room() -> u32 {
    return arrayLength(&partials) / (PARTIAL_TEXELS * sum_index(1u, vec2(0u)));
}
