// Values laid aside, in registers.

import package::shade::asides::ASIDE_COUNT;

var<private> asides: array<vec4<u32>, ASIDE_COUNT>;

fn open_asides(lane: u32) {}

fn forget_asides(any: u32) {}

fn lay_aside(slot: u32, value: vec4<u32>) {
    asides[slot] = value;
}

fn aside(slot: u32) -> vec4<u32> {
    return asides[slot];
}
