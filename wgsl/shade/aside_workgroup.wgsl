// Values laid aside, in workgroup memory: GPUs run more subgroups the fewer registers an invocation has.

import package::shade::asides::ASIDE_COUNT;

const ASIDE_LANES: u32 = 64u; // of a workgroup

var<workgroup> asides: array<array<vec4<u32>, ASIDE_LANES>, ASIDE_COUNT>;
var<private> aside_lane: u32;

fn open_asides(lane: u32) {
    aside_lane = lane;
}

// Compilers would keep values that they know to be laid aside. `any` number changes nothing.
fn forget_asides(any: u32) {
    aside_lane = min(aside_lane, any | (ASIDE_LANES - 1u));
}

fn lay_aside(slot: u32, value: vec4<u32>) {
    asides[slot][aside_lane] = value;
}

fn aside(slot: u32) -> vec4<u32> {
    return asides[slot][aside_lane];
}
