// Unit vectors and colours in few bits. Rust: src/records/pack.rs.

import package::records::material::TRANSFER_GAIN;

// Unit vectors packed in two snorm16 (Cigolle et al. 2014, section 3).
fn octahedral(v: vec3<f32>) -> u32 {
    let n = v / max(abs(v.x) + abs(v.y) + abs(v.z), 1e-20);
    let sides = select(vec2(-1.0), vec2(1.0), n.xy >= vec2(0.0));
    return pack2x16snorm(select(n.xy, (1.0 - abs(n.yx)) * sides, n.z < 0.0));
}

fn from_octahedral(bits: u32) -> vec3<f32> {
    let e = unpack2x16snorm(bits);
    let z = 1.0 - abs(e.x) - abs(e.y);
    let sides = select(vec2(-1.0), vec2(1.0), e >= vec2(0.0));
    return normalize(vec3(select(e, (1.0 - abs(e.yx)) * sides, z < 0.0), z));
}

// Colours of casters in records, 16 bits a channel: the root of 1 - c, so that a nearly white caster keeps
// its absorption; for a `gain` material, the root of c / 16.

// `color`: divided by 16 for `gain`. The high half of the second word is 0.
fn pack_color(color: vec3<f32>, transfer: u32) -> vec2<u32> {
    let c = clamp(color, vec3(0.0), vec3(1.0));
    let root = sqrt(select(1.0 - c, c, transfer == TRANSFER_GAIN));
    return vec2(pack2x16unorm(root.rg), pack2x16unorm(vec2(root.b, 0.0)));
}

// 1 - c, for all materials but `gain`.
fn unpack_absorbed(bits: vec2<u32>) -> vec3<f32> {
    let root = vec3(unpack2x16unorm(bits.x), unpack2x16unorm(bits.y).x);
    return root * root;
}

// Divided by 16 for `gain`.
fn unpack_color(bits: vec2<u32>, transfer: u32) -> vec3<f32> {
    let squared = unpack_absorbed(bits);
    return select(1.0 - squared, squared, transfer == TRANSFER_GAIN);
}
