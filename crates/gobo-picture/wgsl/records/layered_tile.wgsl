// Tiles of a band that have translucent casters. `layered_tiles` holds the workgroups of a dispatch over them
// in x, y and z, and then their indices in the band. Rust: crates/gobo-picture/src/stage/shade.rs.

const LAYERED_HEAD: u32 = 3u; // words
