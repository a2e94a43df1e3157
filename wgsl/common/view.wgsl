// One shadow camera. Rust: `GpuView` in src/view.rs.
struct GpuView {
    view_from_world: mat4x4<f32>,
    size: vec2<f32>,      // [texels]
    scale: f32,           // texels per metre, of a perspective view at 1 m along the axis
    perspective: f32,     // 1 or 0
    near: f32,            // [m]
    far: f32,             // [m]
    first_tile: u32,      // of the view in its batch
    tiles_x: u32,
    origin: vec2<u32>,    // in the atlas [texels]
    layer: u32,
    light: u32,
}

const TILE_SIZE: u32 = 16u; // edge [texels]
const MAX_VIEWS: u32 = 64u; // of a batch
