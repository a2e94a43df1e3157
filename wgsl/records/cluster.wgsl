// What the steps of `cluster` share. Rust: src/stage/cluster.rs.

struct ClusterParams {
    cells: vec3<u32>,  // in x, y and depth
    cluster_count: u32,
    light_count: u32,
    word_count: u32,   // words of bits of a cluster
    capacity: u32,     // lights that all lists together have room for
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
