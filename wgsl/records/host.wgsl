// Host casters in the host's buffers. Rust: src/records/host.rs.

// Return value of the host's `load_caster`.
struct Caster {
    center: vec3<f32>, // world space [m]
    radius: f32,       // [m]
    color: vec4<f32>,  // linear rgba; multiplies the material's tint
    rotation: f32,     // rotation of a quad about the ray from the light [radians]
    material: u32,     // index
    id: u32,           // seed of dither patterns
}

// Return value of the host's `load_gaussian`.
struct Gaussian {
    center: vec3<f32>,   // world space [m]
    opacity: f32,        // at the centre
    rotation: vec4<f32>, // unit quaternion x, y, z, w: from its own space to the world
    sigma: vec3<f32>,    // standard deviations along its axes [m]
    material: u32,       // index
    color: vec3<f32>,    // linear rgb; multiplies the material's tint
    id: u32,             // seed of dither patterns
}

// Values of a material that its Gaussians need.
struct GaussianLook {
    marks: u32,   // NEUTRAL_BIT, MEDIUM_BIT
    density: f32, // extinction of a medium of opacity 1 [1/m]
    most: f32,    // largest opacity
    pad: u32,
}

struct LoadParams {
    capacity: u32,      // capacity of the set [casters]
    is_counted: u32,    // 1: the number of casters is in `host_counts`
    count_index: u32,
    group_count: u32,   // of the set
    first_group: u32,
    first_caster: u32,  // of the first group, in the buffer of records
    quad_reach: f32,    // reach of a quad in its group's box [radii]
    may_be_none: u32,   // 1: a caster without a radius is no caster, and is not counted
    materials: array<vec4<u32>, 4>, // bits: materials that the set may use
    first_axes: u32,    // axes of the first group's first Gaussian, in the buffer of records
    first_record: u32,  // of the buffer, among all records
    pad_0: u32,
    pad_1: u32,
}

// A run of casters of a set: one workgroup of `load`.
struct HostGroup {
    low: vec3<f32>, // corner of the box around their spheres [m]
    count: u32,     // number of valid casters, which are the group's first records
    high: vec3<f32>,
    least_alpha: f32,
}

// Reset before each frame.
struct LoadCounters {
    taken: atomic<u32>,
    skipped: atomic<u32>, // casters with a number that is infinite, NaN or out of range
}

// In one buffer, since five of WebGPU's eight are the host's own.
struct LoadedGroups {
    @size(32) counters: LoadCounters, // as large as a group
    groups: array<HostGroup>,
}

// A grid of the host, and the slots of its bricks.
struct HostGridParams {
    size: vec3<u32>,    // [voxels]
    first_slot: u32,    // of its first brick in `voxels`
    bricks: vec2<u32>,  // along x and y
    slots: vec2<u32>,   // of `voxels` along x and y
    brick_count: u32,
    first_record: u32,  // of its first brick in `bricks`
    material: u32,
    pad: u32,
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

// Number of host casters in a list.
const CHUNK_SIZE: u32 = 256u; // casters of a group
const MAX_COORDINATE: f32 = 1e7; // [m]
