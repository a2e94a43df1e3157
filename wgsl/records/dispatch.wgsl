// Entries of `dispatches`: workgroup counts in x, y, z and their sum in w. Rust: src/stage/bin.rs.

const OVERFLOW_DISPATCH: u32 = 0u;
const SEGMENT_DISPATCH: u32 = 1u;
const MERGED_DISPATCH: u32 = 2u;
const OVERFLOW_SLICES: u32 = 8u; // workgroups that share the tiles of one overflowed footprint

// Of a dispatch in rows: a row has fewer workgroups than a device's limit.
fn workgroup_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup.y * workgroups.x + workgroup.x;
}
