// Entries of `dispatches`: workgroup counts in x, y, z and their sum in w. Rust: src/stage/bin.rs.

const OVERFLOW_DISPATCH: u32 = 0u;
const SEGMENT_DISPATCH: u32 = 1u;
const MERGED_DISPATCH: u32 = 2u;
const OVERFLOW_SLICES: u32 = 8u; // workgroups that share the tiles of one overflowed footprint
