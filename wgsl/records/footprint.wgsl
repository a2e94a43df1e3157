// What `project` leaves of a caster in a view: two texels of `footprints`, `place` and `look`. Rust:
// `Footprint` in src/records/footprint.rs.

import package::records::tile_rect::INVISIBLE;

// No later footprint of the same tile has a smaller one.
fn footprint_key(look: vec4<u32>) -> u32 {
    return look.z >> 16u;
}

// The depth that no footprint of a larger key is in front of.
fn key_depth(key: u32) -> f32 {
    return f32(key) / f32(INVISIBLE - 1u);
}

fn front_depth(look: vec4<u32>) -> f32 {
    return key_depth(footprint_key(look));
}
