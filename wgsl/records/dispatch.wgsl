// Entries of `dispatches`: workgroup counts in x, y, z and their sum in w. Rust: src/stage/bin.rs.

const OVERFLOW_DISPATCH: u32 = 0u;
const SEGMENT_DISPATCH: u32 = 1u;
const MERGED_DISPATCH: u32 = 2u;
// Where some footprints did not fit, all footprints of the list go through parts of its tiles
// (wgsl/bin/part_*.wgsl).
const PART_COUNT_DISPATCH: u32 = 3u;
const PART_DISPATCH: u32 = 4u;   // one workgroup per tile of the part; w: its first tile
const PARTED_DISPATCH: u32 = 5u; // x: 1 if they do; w: the tile behind the part
const OVERFLOW_SLICES: u32 = 8u; // workgroups that share the tiles of one overflowed footprint

// Number of a workgroup in a dispatch of rows: a row has fewer workgroups than a device's limit.
fn workgroup_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup.y * workgroups.x + workgroup.x;
}
