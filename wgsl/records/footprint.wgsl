// Footprint of a caster in a view, written by `project`.

import package::features::SETUPS_IN_ORDER;
import package::records::pack::unpack_color;
import package::records::record::{OPACITY_SCALE, TRIANGLE_BIT};
import package::records::tile::INVISIBLE;
import choice::records::{footprint_record, setup_words};

// Projected radius below which a particle is enlarged and thinned, and a strand widened [texels].
const MIN_RADIUS: f32 = 0.70710678;

// A record's members, packed ones read by the functions below.
struct Footprint {
    bounds: vec4<f32>,
    look: vec4<u32>,
    is_triangle: bool,
}

// Index of the particle in `casters`, or with TRIANGLE_BIT of the triangle in `triangles`.
fn caster_of(footprint: Footprint) -> u32 {
    return footprint.look.w;
}

// Index of a triangle in `setups`.
fn setup_of(footprint: Footprint) -> u32 {
    return footprint.look.x;
}

// A particle's colour; `transfer`: of its material.
fn footprint_color(footprint: Footprint, transfer: u32) -> vec3<f32> {
    return unpack_color(footprint.look.xy, transfer);
}

// Ratio of a particle's area to its projected area, which is no smaller than a texel.
fn footprint_thin(footprint: Footprint) -> f32 {
    return unpack2x16float(footprint.look.z).x / OPACITY_SCALE;
}

// Slope of a particle's thinned opacity: the opacity is the reflectivity times `footprint_thin`, plus this
// times the profile.
fn opacity_slope(footprint: Footprint) -> f32 {
    return unpack2x16float(footprint.look.y).y / OPACITY_SCALE;
}

// Depth key; no later footprint of the same tile has a smaller one.
fn footprint_key(footprint: Footprint) -> u32 {
    return footprint.look.z >> 16u;
}

// Least depth of the footprints with key `key` or larger.
fn key_depth(key: u32) -> f32 {
    return f32(key) / f32(INVISIBLE - 1u);
}

fn front_depth(footprint: Footprint) -> f32 {
    return key_depth(footprint_key(footprint));
}

// Footprints from `footprints`.
fn load_footprint(id: u32) -> Footprint {
    let record = footprint_record(id);
    var footprint = Footprint(record.bounds, record.look, (record.look.w & TRIANGLE_BIT) != 0u);
    if SETUPS_IN_ORDER {
        // A setup can then be loaded without waiting for the footprint.
        footprint.look.x = id;
    }
    return footprint;
}

// Triangle setup, written by `project`: a record of `setups`.

const BACK_BIT: u32 = 8u; // flag of a setup's ties: clockwise as seen from the light
const SETUP_TEXELS: u32 = 8u;

fn setup_texel(setup: u32, texel: u32) -> vec4<u32> {
    return setup_words(setup * SETUP_TEXELS + texel);
}
