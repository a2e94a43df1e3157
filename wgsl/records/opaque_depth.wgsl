// Opaque depths in the format of maps: the last bit marks a dithered surface, because softening fills only
// the holes of dithered surfaces. CPU reference: crates/gobo-reference/src/occlude.rs.

const DITHERED_BIT: u32 = 1u;

fn is_dithered(depth: f32) -> bool {
    return (bitcast<u32>(depth) & DITHERED_BIT) == DITHERED_BIT;
}

fn opaque_bits(depth: f32, dithered: bool) -> u32 {
    let bits = bitcast<u32>(depth) & ~DITHERED_BIT;
    return select(bits, bits | DITHERED_BIT, dithered);
}
