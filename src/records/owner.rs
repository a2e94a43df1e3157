//! Owner tag of a texel's nearest translucent depth, for receivers that ignore their own object's casters.
//! WGSL: `wgsl/records/texel.wgsl`.

/// Tag of a texel without a translucent hit, or of one that was scattered.
pub const NO_OWNER: u16 = 0;
/// Bits of the depth in a stored tag.
pub const DEPTH_TAG_BITS: u32 = 5;

/// 16 bits of an object's id, never 0.
pub fn owner_tag(id: u32) -> u16 {
    ((id ^ (id >> 16)) as u16).max(1)
}

/// Tag stored in a texel: high bits in the filter texture's alpha, low bits in its nearest depth.
pub fn stored_tag(alpha: f32, depth: f32) -> u16 {
    let low = depth.to_bits() & ((1 << DEPTH_TAG_BITS) - 1);
    (((alpha as u32) << DEPTH_TAG_BITS) | low) as u16
}
