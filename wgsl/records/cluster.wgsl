// Records that the steps of `cluster` share. Rust: src/records/cluster.rs.

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
const ALL_LIGHTS: u32 = 0xffffffffu; // for a list that did not fit
