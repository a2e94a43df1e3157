// Emitters and their particles. Rust: the same names in src/records/emitter.rs.

import package::bind::uniform::emitter_params;

struct EmitterParams {
    position: vec3<f32>,  // [m]
    seed: u32,
    extent: vec3<f32>,    // full size [m]
    shape: u32,           // EMITTER_*
    velocity: vec3<f32>,  // mean initial velocity [m/s]
    spread: f32,          // [m/s]
    wind: vec3<f32>,      // [m/s]
    drag: f32,            // [1/s]
    origin: vec3<f32>,    // world position of the scene's origin [m]
    turbulence: f32,      // [m/s]
    frequency: f32,       // [1/m]
    evolve: f32,          // [m/s]
    gravity: f32,         // [m/s^2]
    buoyancy: f32,        // [m/s^2]
    life_least: f32,      // [s]
    life_most: f32,       // [s]
    bounce: f32,
    slide: f32,
    ground: f32,          // height; the least number for no ground [m]
    period: f32,          // time from one particle to the next [s]
    box_count: u32,
    capacity: u32,        // largest number of particles that are alive at once
    step: u32,            // first time step of the dispatch
    step_count: u32,      // at most STEPS_AT_ONCE
    path_count: u32,      // at least 1
    first_birth: f32,     // start of a dispatch's first particle, if the emitter moves [s from its step]
    started: array<vec4<u32>, 3>,    // particles started before each step, and after the last
    boxes: array<vec4<f32>, 16>,     // lower and upper corners [m]
    path: array<vec4<f32>, 32>,      // x: time [s from the dispatch's step]; yzw: the emitter's offset [m]
}

// State of an emitter's particles at a moment, and their looks. Rust: the same name in
// src/records/emitter.rs.
struct EmissionParams {
    first: u32,       // number of the oldest particle that may be alive
    capacity: u32,    // slots of the ring
    seed: u32,
    part: f32,        // time since the last step [steps]
    material: u32,
    first_id: u32,
    radius_count: u32,
    color_count: u32,
    alpha_count: u32,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
    radii: array<vec4<f32>, 4>,   // over a life, at even distances [m]
    shades: array<vec4<f32>, 16>, // rgb and alpha over a life, at even distances
}

struct GpuEmitted {
    position: vec3<f32>, // [m]
    number: u32,         // index among the emitter's particles
    velocity: vec3<f32>, // [m/s]
    age_life: u32,       // age in the low, lifetime in the high 16 bits [steps]
}

const EMITTER_POINT: u32 = 0u;
const EMITTER_BOX: u32 = 1u;
const EMITTER_SPHERE: u32 = 2u;
const EMITTER_DISC: u32 = 3u;

const STEPS_AT_ONCE: u32 = 8u;
const STEPS_PER_SECOND: f32 = 60.0;
const STEP_SECONDS: f32 = 0.016666668;

// Number of an emitter's particles that have started before one of the steps of a dispatch, or after the
// last.
fn started_before(step: u32) -> u32 {
    return emitter_params.started[step / 4u][step % 4u];
}
