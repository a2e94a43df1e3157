// Rust: `AirParams` in src/stage/air.rs.

struct AirParams {
    scattering: vec3<f32>, // [1/m]
    anisotropy: f32,       // of Henyey and Greenstein 1941
    extinction: vec3<f32>, // [1/m]
    slices: u32,
    ambient: vec3<f32>,    // light from everywhere, as much of it as is scattered
    samples: u32,          // of a slice
}

const AIR_CELL: u32 = 4u; // edge of a column [pixels]
