// Rust: `AirParams` in src/stage/air.rs.

struct AirParams {
    albedo: vec3<f32>,
    density: f32,    // extinction [1/m]
    anisotropy: f32, // of Henyey and Greenstein 1941
    slices: u32,
    samples: u32,    // of a slice
    pad_0: u32,
}

const AIR_CELL: u32 = 4u; // edge of a column [pixels]
