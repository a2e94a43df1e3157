// Packs a host's caster into the record that its upload would make, bit for bit if the device divides as in
// IEEE 754. Rust: `Caster::new` in src/records/caster.rs.

import package::bind::uniform::materials;
import package::records::host::Caster;
import package::records::material::{MAX_GAIN, TRANSFER_GAIN};
import package::records::record::OPACITY_SCALE;

const TURN: f32 = 6.2831853; // [radians]

fn packed_position(caster: Caster) -> vec4<u32> {
    return vec4(bitcast<vec3<u32>>(caster.center), bitcast<u32>(caster.radius));
}

// Linear rgb as in wgsl/records/color.wgsl; divided by 16 for a `gain` material.
fn packed_color(color: vec3<f32>, material: u32) -> vec3<u32> {
    let is_gain = materials[material].transfer == TRANSFER_GAIN;
    let squared = select(1.0 - color, color / MAX_GAIN, is_gain);
    return vec3<u32>(floor(0.5 + 65535.0 * sqrt(squared)));
}

fn packed_look(caster: Caster) -> vec4<u32> {
    let levels = packed_color(caster.color.rgb, caster.material);
    let turns = caster.rotation / TURN;
    let part = turns - floor(turns);
    // Halves are rounded up, as in the CPU reference.
    let angle = u32(floor(part * 65536.0 + 0.5)) & 0xffffu;
    return vec4(
        levels.r | (levels.g << 16u),
        levels.b | (half_bits(caster.color.a * OPACITY_SCALE) << 16u),
        caster.material | (angle << 16u),
        caster.id,
    );
}

// f16 of a number in 0..65504, rounded to nearest even: `pack2x16float` may round otherwise.
fn half_bits(x: f32) -> u32 {
    const MIN_NORMAL: f32 = 6.1035156e-5;
    if x < MIN_NORMAL {
        return u32(round(x * 16777216.0));
    }
    let bits = bitcast<u32>(x);
    // Exponents of f32 have a bias of 127, of f16 one of 15.
    return ((bits + 0xfffu + ((bits >> 13u) & 1u)) >> 13u) - (112u << 10u);
}
