// A particle as uploaded: two texels of `casters`. Rust: `Caster` in src/records/caster.rs.

import package::bind::sampled::casters;
import package::records::record::record_texel;

const CASTER_TEXELS: u32 = 2u;

// Colour, material and rotation, and id of the object.
fn caster_look(caster: u32) -> vec4<u32> {
    return textureLoad(casters, record_texel(CASTER_TEXELS * caster + 1u), 0);
}

// Rotation about the ray [radians]; `look`: the word with the material.
fn look_rotation(look: u32) -> f32 {
    return f32(look >> 16u) * (6.2831853 / 65536.0);
}

fn look_material(look: vec4<u32>) -> u32 {
    return look.z & 0xffffu;
}

fn caster_rotation(caster: u32) -> f32 {
    return look_rotation(caster_look(caster).z);
}

// Id of the particle's object.
fn particle_object(caster: u32) -> u32 {
    return caster_look(caster).w;
}
