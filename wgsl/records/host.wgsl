// Casters in buffers of the host's. Rust: src/records/host.rs.

// What the host's `load_caster` returns.
struct Caster {
    center: vec3<f32>, // world space [m]
    radius: f32,       // [m]
    color: vec4<f32>,  // linear rgba; multiplies the material's tint
    rotation: f32,     // of a quad about the ray from the light [radians]
    material: u32,     // index
    id: u32,           // decorrelates dither patterns
}

struct LoadParams {
    capacity: u32,      // casters of the set at most
    is_counted: u32,    // 1: how many there are is in `host_counts`
    count_index: u32,
    group_count: u32,   // of the set
    first_group: u32,
    first_caster: u32,  // record of the first group's first caster
    pad_0: u32,
    pad_1: u32,
    materials: array<vec4<u32>, 4>, // that the set may have, a bit each
}

// Casters of a set side by side: one workgroup of `load`.
struct HostGroup {
    low: vec3<f32>, // of the box around their spheres [m]
    count: u32,     // usable casters, the group's first records
    high: vec3<f32>,
    pad_0: u32,
}

// Reset before each frame.
struct LoadCounters {
    taken: atomic<u32>,
    skipped: atomic<u32>, // that have a number that is not finite or out of range
}

struct CullParams {
    view_count: u32,
    group_count: u32,     // of the list
    first_group: u32,
    first_caster: u32,    // record of the first caster of all sets
    first_footprint: u32, // of the list's host casters
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}

// What a list holds of them.
struct Listed {
    chunk_count: u32,
    footprint_end: u32, // with all that the list has before them
}

const CHUNK_SIZE: u32 = 256u; // casters of a group
const FARTHEST_PLACE: f32 = 1e7; // [m]
