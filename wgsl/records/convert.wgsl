// Conversion of a view's maps to a layout of the host. Rust: `ConvertParams` in src/records/convert.rs.

struct ConvertParams {
    clip_from_view: mat4x4<f32>, // the host's clip space from our view space
    size: vec2<f32>,       // of the map [texels]
    scale: f32,            // as in `GpuView`
    perspective: f32,      // 1 or 0
    near: f32,             // [m]
    far: f32,              // [m]
    origin: vec2<u32>,     // in the atlas [texels]
    layer: u32,
    width: u32,            // of the atlas [texels]
    has_depth: u32,        // 1: alpha is the host's depth of the nearest translucent hit
    empty: f32,            // alpha without a translucent hit
}

const FORMAT_RGBA16FLOAT: u32 = 0u;
const FORMAT_RGBA8UNORM: u32 = 1u;
const FORMAT_RG11B10UFLOAT: u32 = 2u;
