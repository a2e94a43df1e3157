// Light of casters so faint that 1 - a (1 - c) loses their absorption to rounding. CPU reference:
// crates/gobo-reference/src/hit.rs.

import package::sums::sums::to_tau;

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
