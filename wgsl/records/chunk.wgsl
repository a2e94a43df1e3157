// A run of casters for one view: the unit of work of `project`. Rust: `Chunk` in
// src/stage/project.rs.

struct Chunk {
    view: u32,
    first_caster: u32,
    count: u32,           // at most the workgroup's size
    first_footprint: u32,
}

struct ProjectParams {
    chunk_count: u32,
    // 1: tiny particles take the scatter path.
    scatter: u32,
    // Footprint of the first triangle less the index of its setup, modulo 2^32: setups of Gaussians come
    // first.
    first_setup: u32,
    // Footprint of the Gaussian with setup 0, modulo 2^32.
    first_gaussian: u32,
    // 1: the camera's list includes casters without shadows.
    include_non_casters: u32,
    // 1: depth keys of perspective views are distances from the light or the eye.
    by_distance: u32,
}
