// Import of one view's depth map from the host. Rust: `ImportParams` in src/records/import.rs.

struct ImportParams {
    clip_from_view: mat4x4<f32>, // the host's clip space from our view space
    size: vec2<f32>,       // of our map [texels]
    host_size: vec2<f32>,  // of the host's [texels]
    scale: f32,            // as in `GpuView`
    perspective: f32,      // 1 or 0, of our view
    near: f32,             // [m]
    far: f32,              // [m]
    origin: vec2<u32>,     // in the atlas [texels]
    layer: u32,
    replaces: u32,         // 1: replaces the depth of our own opaque casters
    empty: f32,            // the host's clear depth
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}
