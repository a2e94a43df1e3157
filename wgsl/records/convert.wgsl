// A view's maps in a layout of the host's. Rust: `ConvertParams` in src/records/convert.rs.

struct ConvertParams {
    clip_from_view: mat4x4<f32>, // of the host's camera, from ours
    size: vec2<f32>,       // of the map [texels]
    scale: f32,            // as in `GpuView`
    perspective: f32,      // 1 or 0
    near: f32,             // [m]
    far: f32,              // [m]
    origin: vec2<u32>,     // in the atlas [texels]
    layer: u32,
    width: u32,            // of the atlas [texels]
    has_depth: u32,        // 1: alpha is the host's depth of what filters first
    empty: f32,            // alpha where nothing filters
}

const FORMAT_RGBA16FLOAT: u32 = 0u;
const FORMAT_RGBA8UNORM: u32 = 1u;
const FORMAT_RG11B10UFLOAT: u32 = 2u;
