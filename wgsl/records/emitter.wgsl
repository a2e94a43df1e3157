// Particles that an emitter sends out. Rust: the same names in src/records/emitter.rs.

struct EmitterParams {
    position: vec3<f32>,  // [m]
    seed: u32,
    extent: vec3<f32>,    // whole [m]
    source: u32,          // SOURCE_*
    velocity: vec3<f32>,  // at the start [m/s]
    spread: f32,          // [m/s]
    wind: vec3<f32>,      // [m/s]
    drag: f32,            // [1/s]
    origin: vec3<f32>,    // of the scene, in the world [m]
    turbulence: f32,      // [m/s]
    frequency: f32,       // [1/m]
    evolve: f32,          // [m/s]
    gravity: f32,         // [m/s^2]
    buoyancy: f32,        // [m/s^2]
    life_least: f32,      // [s]
    life_most: f32,       // [s]
    bounce: f32,
    slide: f32,
    ground: f32,          // [m]
    has_ground: u32,      // 1 or 0
    box_count: u32,
    capacity: u32,        // particles that fly at a time, at most
    step: u32,            // of time, the first that is made
    step_count: u32,      // at most STEPS_AT_ONCE
    pad_0: u32,
    pad_1: u32,
    started: array<vec4<u32>, 3>,    // particles before each of the steps, and behind the last
    boxes: array<vec4<f32>, 16>,     // lower and upper corners [m]
}

struct GpuFlying {
    position: vec3<f32>, // [m]
    number: u32,         // of the emitter's
    velocity: vec3<f32>, // [m/s]
    age_life: u32,       // steps so far, and above 16 bits in all
}

const SOURCE_POINT: u32 = 0u;
const SOURCE_BOX: u32 = 1u;
const SOURCE_SPHERE: u32 = 2u;
const SOURCE_DISC: u32 = 3u;

const STEPS_AT_ONCE: u32 = 8u;
const STEPS_PER_SECOND: f32 = 60.0;
const STEP_SECONDS: f32 = 0.016666668;
