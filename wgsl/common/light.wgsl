// Lights of the picture. Rust: `GpuLight` and `PictureParams` in src/stage/shade.rs.
// Needs common/view.wgsl.
struct GpuLight {
    position: vec3<f32>,  // world space [m]
    kind: u32,
    direction: vec3<f32>, // of travel, unit, world space
    first_view: u32,
    color: vec3<f32>,     // times intensity
    view_count: u32,      // 0: casts no shadow
    cone_outer: f32,      // cosines of half the angle of a spot
    cone_inner: f32,
    shafts: u32,          // 1 where the air scatters its light
    pad_0: u32,
}

const LIGHT_DIRECTIONAL: u32 = 0u;
const LIGHT_SPOT: u32 = 1u;
const LIGHT_POINT: u32 = 2u;
const MAX_LIGHTS: u32 = 512u;
const MAX_SHADOW_VIEWS: u32 = 512u;

struct PictureParams {
    world_from_view: mat4x4<f32>, // of the camera
    ambient: vec3<f32>,
    light_count: u32,
    background: vec3<f32>,
    footprint_count: u32,
    bias: f32,        // [m]
    normal_bias: f32, // [texels]
    colored: u32,     // 1 where opaque depths are by channel
    air_slices: u32,  // 0: the air is clear
}
