// What `project` leaves of a caster in a view: two texels of `footprints`. Rust: `Footprint` in
// src/records/footprint.rs.

import package::records::record::{OPACITY_SCALE, TRIANGLE_BIT};
import package::records::tile_rect::INVISIBLE;

struct Footprint {
    // Centre and radius [texels], light depth; what `is_beside` a view has its centre in metres.
    place: vec4<f32>,
    // Colour, opacity, depth key and caster, packed: read by the functions below.
    look: vec4<u32>,
}

fn footprint_of(place: vec4<u32>, look: vec4<u32>) -> Footprint {
    return Footprint(bitcast<vec4<f32>>(place), look);
}

fn is_triangle(footprint: Footprint) -> bool {
    return (footprint.look.w & TRIANGLE_BIT) != 0u;
}

// The particle's place among `casters`, or the triangle's among `triangles` with TRIANGLE_BIT.
fn caster_of(footprint: Footprint) -> u32 {
    return footprint.look.w;
}

// A triangle's place among `setups`.
fn setup_of(footprint: Footprint) -> u32 {
    return footprint.look.x;
}

// A particle's colour.
fn footprint_color(footprint: Footprint) -> vec3<f32> {
    return vec3(unpack2x16unorm(footprint.look.x), unpack2x16unorm(footprint.look.y).x);
}

// A particle's opacity is `opacity_base` and `opacity_slope` times its profile.
fn opacity_base(footprint: Footprint) -> f32 {
    return unpack2x16float(footprint.look.z).x / OPACITY_SCALE;
}

fn opacity_slope(footprint: Footprint) -> f32 {
    return unpack2x16float(footprint.look.y).y / OPACITY_SCALE;
}

// No later footprint of the same tile has a smaller one.
fn footprint_key(footprint: Footprint) -> u32 {
    return footprint.look.z >> 16u;
}

// The depth that no footprint of a larger key is in front of.
fn key_depth(key: u32) -> f32 {
    return f32(key) / f32(INVISIBLE - 1u);
}

fn front_depth(footprint: Footprint) -> f32 {
    return key_depth(footprint_key(footprint));
}
