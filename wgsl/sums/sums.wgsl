// Light in fixed point: integer sums do not depend on the order. CPU reference:
// crates/gobo-reference/src/resolve.rs.

import package::features::HAS_GAIN;

const FIXED_ONE: f32 = 65536.0; // of optical depth
// Largest addend: past ln 1024 a texel is black. 4,096 addends in flight on one texel stay below 2^31.
const MAX_TAU: f32 = 7.0;
const SATURATED: u32 = 458752u; // MAX_TAU in fixed point
const BRIGHTEST: f32 = 256.0; // largest transmittance of one addend: two `gain` casters of 16
const BLACK: f32 = 0.0009765625; // transmittance below which a texel is 0: 1/1024
const VISIBLE_PRESENCE: f32 = 0.003921569; // least presence of a hit that sets the nearest depth: 1/255

fn to_tau(t: vec3<f32>) -> vec3<f32> {
    return min(-log(clamp(t, vec3(1e-9), vec3(BRIGHTEST))), vec3(MAX_TAU));
}

fn light(sums: vec3<u32>) -> vec3<f32> {
    // At most the largest finite half.
    return min(exp(vec3<f32>(bitcast<vec3<i32>>(sums)) * (-1.0 / FIXED_ONE)), vec3(65504.0));
}

// Zero below `BLACK`, so that early termination changes no bit.
fn blackened(t: vec3<f32>) -> vec3<f32> {
    return select(select(t, vec3(0.0), t < vec3(BLACK)), t, HAS_GAIN);
}

// Depths 0..1 are ordered like their bits; cleared sums mean depth 1.
const ONE_BITS: u32 = 0x3f800000u;

fn depth_to_nearness(depth: f32) -> u32 {
    return ONE_BITS - bitcast<u32>(depth);
}

fn nearness_to_depth(value: u32) -> f32 {
    return bitcast<f32>(ONE_BITS - value);
}
