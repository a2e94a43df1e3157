// Rust: `AirParams` in src/records/air.rs.

struct AirParams {
    scattering: vec3<f32>, // coefficient [1/m]
    anisotropy: f32,       // `g` of Henyey and Greenstein 1941
    extinction: vec3<f32>, // coefficient [1/m]
    slices: u32,
    ambient: vec3<f32>,    // ambient radiance times the share that is scattered
    samples: u32,          // per slice
}

const AIR_CELL: u32 = 4u; // edge of a column [pixels]
