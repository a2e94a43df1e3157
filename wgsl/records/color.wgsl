// Colours of casters in records, 16 bits a channel: the root of 1 - c, so that a nearly white caster keeps
// its absorption; for a `gain` material, the root of c / 16. Rust: `color_bits` in src/records/pack.rs.

import package::records::material::TRANSFER_GAIN;

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
