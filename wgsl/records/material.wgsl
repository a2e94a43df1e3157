// Rust: `GpuMaterial` in src/records/material.rs; the numbers are those of `Transfer`, `Shape` and
// `Profile` in src/model/caster.rs.

struct GpuMaterial {
    tint: vec4<f32>, // linear rgba
    emission: vec3<f32>,
    transmission: f32,
    transfer: u32,
    shape: u32,
    profile: u32,
    texture: u32, // layer, NO_TEXTURE for none
    texture_size: vec2<f32>, // [texels]
    reflectivity: f32,
    cutoff: f32,
    roughness: f32,
    pattern: u32,
    pattern_scale: u32, // [texels of a cell]
    blue_first: u32,    // first record of the blue noise in `casters`
    absorption: vec3<f32>, // coefficient inside a closed mesh [1/m]
    receives: u32,
    emissive_size: vec2<f32>, // of the emissive texture [texels]
    emissive_texture: u32,    // layer, NO_TEXTURE for none
    metallic: f32,
    ior: f32,   // of its bodies; 1: light goes straight through
    frost: f32, // blur of the scene behind it, per distance
    fresnel: f32, // refractive index of its faces, or minus that of its panes; 0: no reflection
    shows: u32,   // SHOWS_*; from FAR_SIDE_SHIFT and DETAILS_SHIFT on indices of materials plus 1, or 0
}

const MAX_MATERIALS: u32 = 512u;
const NO_TEXTURE: u32 = 0xffffffffu;

const SHOWS_SURROUNDINGS: u32 = 1u; // behind it
const SHOWS_COLOR: u32 = 2u;        // its own, whatever the light
const FAR_SIDE_SHIFT: u32 = 8u;
const DETAILS_SHIFT: u32 = 18u;

const TRANSFER_FILTER: u32 = 0u;
const TRANSFER_STAIN: u32 = 1u;
const TRANSFER_SMOKE: u32 = 2u;
const TRANSFER_OVER: u32 = 3u;
const TRANSFER_GAIN: u32 = 4u;
const TRANSFER_NONE: u32 = 5u;
const TRANSFER_OPAQUE: u32 = 6u;
const TRANSFER_CUTOUT: u32 = 7u;
const TRANSFER_DITHER: u32 = 8u;

const SHAPE_DISC: u32 = 0u;
const SHAPE_QUAD: u32 = 1u;
const SHAPE_PUFF: u32 = 2u;
const SHAPE_GAUSSIAN: u32 = 3u;
const SHAPE_BRICK: u32 = 4u;
const SHAPE_CAPSULE: u32 = 5u;

const PROFILE_FLAT: u32 = 0u;
const PROFILE_SOFT: u32 = 1u;

const RECEIVES_CURVE: u32 = 0u;
const RECEIVES_NEAREST: u32 = 1u;
const RECEIVES_OPAQUE: u32 = 2u;
const RECEIVES_OTHERS: u32 = 3u;

const MAX_GAIN: f32 = 16.0;

fn shows_surroundings(material: GpuMaterial) -> bool {
    return (material.shows & SHOWS_SURROUNDINGS) != 0u;
}

// Number of the material of its far side plus 1, or 0.
fn far_side_of(material: GpuMaterial) -> u32 {
    return extractBits(material.shows, FAR_SIDE_SHIFT, DETAILS_SHIFT - FAR_SIDE_SHIFT);
}

fn shows_color(material: GpuMaterial) -> bool {
    return (material.shows & SHOWS_COLOR) != 0u;
}

// Whether the colour of clear texels counts: elsewhere it is invisible, and means of an image are weighted by
// alpha.
fn shows_clear(transfer: u32) -> bool {
    return transfer == TRANSFER_STAIN || transfer == TRANSFER_GAIN || transfer == TRANSFER_OPAQUE;
}
