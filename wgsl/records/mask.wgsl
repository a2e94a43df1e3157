// Surfaces of a mask's pixels, texels of `mask_surfaces` and `mask_points`, and slots of lights. Rust:
// src/records/mask.rs.

import package::bind::sampled::mask_slots;
import package::records::pack::{from_octahedral, octahedral};
import package::records::record::record_texel;

// Rust: `MaskParams` in src/records/mask.rs.
struct MaskParams {
    size: vec2<u32>,     // size of the masks that are computed [pixels]
    step: u32,           // pixels of the picture per pixel of the masks, along an edge
    taps: u32,           // blur taps to each side of the centre
    sensitivity: f32,    // edge-stopping strength
    depth_scale: f32,    // distance up to which the blur has its full width [m]; 0: everywhere
    column: u32,         // 1: a column is blurred, 0: a row
    mask_count: u32,
    anisotropic: u32,    // 1: the blur narrows on slanted surfaces
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}

// Rust: `HostView` in src/records/mask.rs.
struct HostView {
    world_from_clip: mat4x4<f32>,   // inverse of the matrix of the host's depths
    world_from_normal: mat4x4<f32>, // rotation of the normals to world space
    empty: f32,                     // depth without a surface
    is_light_depth: u32,            // 1: depths are light depths of the view
    normals: u32,                   // NORMALS_*
    pad_0: u32,
}

const NORMALS_NONE: u32 = 0u;
const NORMALS_UNORM: u32 = 2u; // 0 is -1

const COLORED_BIT: u32 = 0x80000000u;
const JOINED_BIT: u32 = 0x40000000u;
const SLOTS: u32 = 4u; // per mask

// Flags in the third word of a texel of `mask_surfaces`.
const ROUND_BIT: u32 = 1u << 16u; // a particle: its normal is its face's, and it has a reach
const OFFSET_SHIFT: u32 = 17u;

struct MaskSurface {
    depth: f32,          // light depth of the camera; 1 without a surface
    normal: vec3<f32>,   // interpolated, unit, on the eye's side
    face: vec3<f32>,     // unit, on the eye's side
    reach: f32,          // distance that a caster in the maps may be off the surface [m]
    offset: vec2<u32>,   // offset of the picture's pixel in the mask's
}

const NO_SURFACE: vec4<u32> = vec4(0x3f800000u, 0u, 0u, 0u);

// `is_round`: whether the face's normal is the interpolated one.
fn packed_surface(surface: MaskSurface, is_round: bool) -> vec4<u32> {
    let normal = surface.normal;
    let last = pack2x16float(vec2(normal.z, 0.0)) & 0xffffu;
    return vec4(
        bitcast<u32>(surface.depth),
        pack2x16float(normal.xy),
        last | select(0u, ROUND_BIT, is_round) | offset_bits(surface.offset),
        select(octahedral(surface.face), bitcast<u32>(surface.reach), is_round),
    );
}

fn offset_bits(offset: vec2<u32>) -> u32 {
    return (offset.x | (offset.y << 1u)) << OFFSET_SHIFT;
}

fn surface_depth(texel: vec4<u32>) -> f32 {
    return bitcast<f32>(texel.x);
}

fn surface_normal(texel: vec4<u32>) -> vec3<f32> {
    return vec3(unpack2x16float(texel.y), unpack2x16float(texel.z).x);
}

fn surface_offset(texel: vec4<u32>) -> vec2<u32> {
    return (vec2(texel.z) >> vec2(OFFSET_SHIFT, OFFSET_SHIFT + 1u)) & vec2(1u);
}

fn unpack_surface(texel: vec4<u32>) -> MaskSurface {
    let is_round = (texel.z & ROUND_BIT) != 0u;
    let normal = surface_normal(texel);
    return MaskSurface(
        surface_depth(texel),
        normal,
        select(from_octahedral(texel.w), normal, is_round),
        select(0.0, bitcast<f32>(texel.w), is_round),
        surface_offset(texel),
    );
}

// Receiver of the light at a mask's pixel.
struct MaskPoint {
    position: vec3<f32>, // world space [m]
    receives: u32,       // RECEIVES_*
    tag: u32,            // owner tag of its object
}

fn packed_mask_point(point: MaskPoint) -> vec4<u32> {
    return vec4(bitcast<vec3<u32>>(point.position), point.receives | (point.tag << 16u));
}

fn unpack_mask_point(texel: vec4<u32>) -> MaskPoint {
    return MaskPoint(bitcast<vec3<f32>>(texel.xyz), texel.w & 3u, texel.w >> 16u);
}

// Slot of a light: its mask times SLOTS, plus its channel, plus 1; 0 for none. COLORED_BIT: it has all
// channels of its mask. JOINED_BIT: the host's shadow function applies to it.
fn mask_slot(light: u32) -> u32 {
    return textureLoad(mask_slots, record_texel(light), 0).r;
}

fn slot_number(slot: u32) -> u32 {
    return (slot & ~(COLORED_BIT | JOINED_BIT)) - 1u;
}

fn slot_mask(slot: u32) -> u32 {
    return slot_number(slot) / SLOTS;
}

// Channels of a slot.
fn slot_channels(slot: u32) -> vec4<bool> {
    let in_texel = slot_number(slot) % SLOTS;
    return (vec4(in_texel) == vec4(0u, 1u, 2u, 3u)) | vec4((slot & COLORED_BIT) != 0u);
}

fn pixel_number(pixel: vec2<f32>) -> u32 {
    let texel = vec2<u32>(pixel);
    return texel.x | (texel.y << 16u);
}
