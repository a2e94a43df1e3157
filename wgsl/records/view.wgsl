// One shadow camera. Rust: `GpuView` in src/records/view.rs.

struct GpuView {
    view_from_world: mat4x4<f32>,
    size: vec2<f32>,      // [texels]
    scale: f32,           // texels per metre; in a perspective view at 1 m along the axis
    perspective: f32,     // 1 or 0
    near: f32,            // [m]
    far: f32,             // [m]
    first_tile: u32,      // of the view in its batch
    tiles_x: u32,
    origin: vec2<u32>,    // in the atlas [texels]
    layer: u32,
    light: u32,
    role: u32,            // ROLE_*
    role_index: u32,      // index in its shadow: the cascade, the face
    role_count: u32,      // views of its shadow
    fade: f32,            // width of a window's fading border [texels]
}

const ROLE_WHOLE: u32 = 0u;  // a cone, or a window on the whole scene
const ROLE_FACE: u32 = 1u;   // of a cube
const ROLE_WINDOW: u32 = 2u; // a cascade, or a further shadow: beyond it the next window, or light

const TILE_SIZE: u32 = 16u; // edge [texels]
const MAX_VIEWS: u32 = 256u; // of a batch

// Whether a particle is beside the view, so that its centre has no position in the map, from its footprint's
// first texel. Then x, y and w are its centre to the right, down and along the axis [m], and z is minus its
// radius [m].
fn is_beside(bounds: vec4<f32>) -> bool {
    return bounds.z < 0.0;
}

const MIN_DISTANCE: f32 = 1.17549435e-38; // [m]
