// What a mask's pixel shows, a texel of `mask_surfaces`; and which mask a light is in. Rust:
// src/records/mask.rs.

import package::bind::sampled::mask_slots;
import package::records::octahedral::from_octahedral;
import package::records::record::record_texel;

// Rust: `MaskParams` in src/records/mask.rs.
struct MaskParams {
    size: vec2<u32>,     // of the masks that are made [pixels]
    step: u32,           // pixels of the picture along a pixel of the masks
    taps: u32,           // of the blur, to each side
    along: vec2<u32>,    // the axis of the blur
    sensitivity: f32,    // to depth, of the distance
    depth_scale: f32,    // distance at which the blur is as wide as it gets [m]; 0: everywhere
}

const ROUND_BIT: u32 = 4u;     // of a particle: its normal is its face's, and it has a reach
const COLORED_BIT: u32 = 0x80000000u;
const SLOTS: u32 = 4u; // of a mask

struct MaskSurface {
    depth: f32,          // light depth of the camera; 1 where there is nothing
    face: vec3<f32>,     // unit, on the eye's side
    normal: vec3<f32>,   // interpolated, unit, on the eye's side
    reach: f32,          // how far what is in the maps may lie off it [m]
    receives: u32,       // RECEIVES_*
    tag: u32,            // of its object
    offset: vec2<u32>,   // of the picture's pixel in the mask's
}

fn unpack_surface(texel: vec4<u32>) -> MaskSurface {
    let is_round = (texel.w & ROUND_BIT) != 0u;
    let face = from_octahedral(texel.y);
    return MaskSurface(
        bitcast<f32>(texel.x),
        face,
        select(from_octahedral(texel.z), face, is_round),
        select(0.0, bitcast<f32>(texel.z), is_round),
        texel.w & 3u,
        texel.w >> 16u,
        vec2((texel.w >> 3u) & 1u, (texel.w >> 4u) & 1u),
    );
}

// The slot of a light: its mask times SLOTS and its place there, and 1; 0 for none. COLORED_BIT: it has all
// channels of its mask.
fn mask_slot(light: u32) -> u32 {
    return textureLoad(mask_slots, record_texel(light), 0).r;
}

fn slot_mask(slot: u32) -> u32 {
    return ((slot & ~COLORED_BIT) - 1u) / SLOTS;
}

// Channels of a slot.
fn slot_channels(slot: u32) -> vec4<bool> {
    let own = ((slot & ~COLORED_BIT) - 1u) % SLOTS;
    return (vec4(own) == vec4(0u, 1u, 2u, 3u)) | vec4((slot & COLORED_BIT) != 0u);
}
