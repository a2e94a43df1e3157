// Light in fixed point: integer sums do not depend on the order. CPU reference:
// crates/gobo-reference/src/resolve.rs, crates/gobo-reference/src/hit.rs.

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

// Light of casters so faint that 1 - a (1 - c) loses their absorption to rounding.

// Absorption is kept apart from the transmittance up to this value: a product of transmittances next to 1
// would lose it to rounding.
const FULL: f32 = 0.015625;
// Value below which a few terms of a series are exact.
const SMALL: f32 = 0.015625;

struct Kept {
    passed: vec3<f32>,
    lost: vec3<f32>,
}

fn keep(passed: vec3<f32>, lost: vec3<f32>, absorbed: vec3<f32>) -> Kept {
    let all = lost + absorbed * (1.0 - lost);
    let full = abs(all) > vec3(FULL);
    return Kept(select(passed, passed * (1.0 - all), full), select(all, vec3(0.0), full));
}

// Optical depth of an absorbed share: -ln(1 - x).
fn absorbed_tau(x: vec3<f32>) -> vec3<f32> {
    let series = x * (1.0 + x * (0.5 + x * (1.0 / 3.0 + x * 0.25)));
    return select(to_tau(1.0 - x), series, abs(x) < vec3(SMALL));
}

// Like `absorbed_tau`, with a limit for hits that absorb everything.
fn whole_tau(x: vec3<f32>) -> vec3<f32> {
    let series = x * (1.0 + x * (0.5 + x * (1.0 / 3.0 + x * 0.25)));
    return select(-log(max(1.0 - x, vec3(1e-9))), series, abs(x) < vec3(SMALL));
}

// 1 - exp(-tau)
fn tau_absorbed(tau: vec3<f32>) -> vec3<f32> {
    let series = tau * (1.0 - tau * (0.5 - tau * (1.0 / 6.0 - tau * (1.0 / 24.0))));
    return select(1.0 - exp(-tau), series, abs(tau) < vec3(SMALL));
}
