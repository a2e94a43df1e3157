// Light in fixed point: sums of integers are the same in every order. CPU twin: src/reference/resolve.rs.

import package::features::HAS_GAIN;

const FIXED_ONE: f32 = 65536.0; // of optical depth
// What one addend adds at most: past ln 1024 a texel is black. 4,096 addends in flight on one
// texel stay below 2^31.
const MAX_TAU: f32 = 7.0;
const SATURATED: u32 = 458752u; // MAX_TAU in fixed point
const BRIGHTEST: f32 = 256.0; // what one addend brightens at most: two casters of 16
const BLACK: f32 = 0.0009765625; // transmittance below it is written as 0: 1/1024
const VISIBLE_OPACITY: f32 = 0.003921569; // a hit of at least 1/255 counts for the nearest depth

fn to_tau(t: vec3<f32>) -> vec3<f32> {
    return min(-log(clamp(t, vec3(1e-9), vec3(BRIGHTEST))), vec3(MAX_TAU));
}

fn light(sums: vec3<u32>) -> vec3<f32> {
    // No more than rgba16float holds.
    return min(exp(vec3<f32>(bitcast<vec3<i32>>(sums)) * (-1.0 / FIXED_ONE)), vec3(65504.0));
}

// Zero where next to nothing is left, so that stopping early changes no bit.
fn blackened(t: vec3<f32>) -> vec3<f32> {
    return select(select(t, vec3(0.0), t < vec3(BLACK)), t, HAS_GAIN);
}

// Depths 0..1 are ordered as their bits are; cleared sums mean depth 1.
const ONE_BITS: u32 = 0x3f800000u;

fn depth_to_nearness(depth: f32) -> u32 {
    return ONE_BITS - bitcast<u32>(depth);
}

fn nearness_to_depth(value: u32) -> f32 {
    return bitcast<f32>(ONE_BITS - value);
}
