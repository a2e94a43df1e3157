// Owner tag of the nearest translucent depth: 16 bits of the object's id, for receivers that ignore their
// own object's casters. Eleven bits are in the alpha of the filter, five in the last bits of the depth, for
// lack of storage textures. Rust: src/records/owner.rs.

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
