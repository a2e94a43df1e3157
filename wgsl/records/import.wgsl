// A depth map of the host's, of one view. Rust: `ImportParams` in src/records/import.rs.

struct ImportParams {
    clip_from_view: mat4x4<f32>, // of the host's camera, from ours
    size: vec2<f32>,       // of our map [texels]
    host_size: vec2<f32>,  // of the host's [texels]
    scale: f32,            // as in `GpuView`
    perspective: f32,      // 1 or 0, of our view
    near: f32,             // [m]
    far: f32,              // [m]
    origin: vec2<u32>,     // in the atlas [texels]
    layer: u32,
    replaces: u32,         // 1: what our own opaque casters left does not count
    empty: f32,            // the host's depth where there is nothing
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}
