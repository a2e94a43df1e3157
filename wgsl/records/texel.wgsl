// Sums of a texel, and depths and owner tags in the format of maps. CPU reference:
// crates/gobo-reference/src/occlude.rs. Rust: src/records/owner.rs.

struct TexelSums {
    red: atomic<u32>, // optical depth in fixed point
    green: atomic<u32>,
    blue: atomic<u32>,
    nearness: atomic<u32>,
}

// Opaque depths in the format of maps: the last bit marks a dithered surface, because softening fills only
// the holes of dithered surfaces.

const DITHERED_BIT: u32 = 1u;

fn is_dithered(depth: f32) -> bool {
    return (bitcast<u32>(depth) & DITHERED_BIT) == DITHERED_BIT;
}

fn opaque_bits(depth: f32, dithered: bool) -> u32 {
    let bits = bitcast<u32>(depth) & ~DITHERED_BIT;
    return select(bits, bits | DITHERED_BIT, dithered);
}

// Owner tag of the nearest translucent depth: 16 bits of the object's id, for receivers that ignore their own
// object's casters. Eleven bits are in the alpha of the filter, five in the last bits of the depth, for lack
// of storage textures.

const NO_OWNER: u32 = 0u;
const DEPTH_TAG_BITS: u32 = 5u;
const DEPTH_TAG_MASK: u32 = 31u;

// Tag of an object, never 0.
fn owner_tag(id: u32) -> u32 {
    return max((id ^ (id >> 16u)) & 0xffffu, 1u);
}

fn tagged_alpha(tag: u32) -> f32 {
    return f32(tag >> DEPTH_TAG_BITS);
}

fn tagged_depth(depth: f32, tag: u32) -> f32 {
    // Large enough that no adapter flushes it to 0.
    let bits = bitcast<u32>(max(depth, 1e-6)) & ~DEPTH_TAG_MASK;
    return select(depth, bitcast<f32>(bits | (tag & DEPTH_TAG_MASK)), tag != NO_OWNER);
}

// Owner tag stored in a texel's filter and nearest depth.
fn stored_tag(alpha: f32, depth: f32) -> u32 {
    return (u32(alpha) << DEPTH_TAG_BITS) | (bitcast<u32>(depth) & DEPTH_TAG_MASK);
}

// Light and nearest depth that a walk has found at a texel.
struct Found {
    light: vec3<f32>, // transmittance of all hits in front of the opaque surface
    nearest: f32,     // light depth of the nearest visible hit
    owner: u32,       // its owner tag
}
