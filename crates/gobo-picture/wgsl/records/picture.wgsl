// Parameters of a picture's air and clusters. Rust: `AirParams` in src/records/air.rs,
// src/records/cluster.rs.

struct AirParams {
    scattering: vec3<f32>, // coefficient [1/m]
    anisotropy: f32,       // `g` of Henyey and Greenstein 1941
    extinction: vec3<f32>, // coefficient [1/m]
    slices: u32,
    ambient: vec3<f32>,    // ambient radiance times the share that is scattered
    pictures: u32,         // samples of a pixel, which share those of a slice
}

const AIR_CELL: u32 = 4u; // edge of a column [pixels]

// Records that the steps of `cluster` share.
struct ClusterParams {
    cells: vec3<u32>,  // number in x, y and depth
    cluster_count: u32,
    light_count: u32,
    word_count: u32,   // words of light bits per cluster
    capacity: u32,     // of all lists together [lights]
    pad: u32,
}

// Keeps counting past the capacity; reset before each picture. Rust: `ClusterCounters`.
struct ClusterCounters {
    needed: atomic<u32>,
    overflowed: atomic<u32>,
    longest: atomic<u32>,
    pad: u32,
}

const REACH_TEXELS: u32 = 4u;
