// Slots for values that a look-up of light lays aside while it does not need them (`choice::aside`).

import choice::root::LOCAL_ASIDES;

const ASIDE_POINT: u32 = 0u;   // the receiver's position, and the `reach` of `shadow` [m]
const ASIDE_NORMAL: u32 = 1u;  // its normal, and its lift along that [texels]
const ASIDE_SUM: u32 = 2u;     // light of the windows of a shadow, and their weight
const ASIDE_LEAST: u32 = 3u;   // least light of the shadows
const ASIDE_VIEWS: u32 = 4u;   // indices of the view and of the shadow's last one, ...
const ASIDE_PASSED: u32 = 5u;  // ... see `through_levels`
const ASIDE_HIDDEN: u32 = 6u;
const ASIDE_LOCAL: u32 = 7u;   // from here on: for the kernel alone
const ASIDE_COUNT: u32 = ASIDE_LOCAL + LOCAL_ASIDES;

fn bits_of(xyz: vec3<f32>, w: f32) -> vec4<u32> {
    return bitcast<vec4<u32>>(vec4(xyz, w));
}

fn floats_of(bits: vec4<u32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bits);
}

// Values laid aside, in registers.

var<private> asides: array<vec4<u32>, ASIDE_COUNT>;

fn open_asides(lane: u32) {}

fn forget_asides(any: u32) {}

fn lay_aside(slot: u32, value: vec4<u32>) {
    asides[slot] = value;
}

fn aside(slot: u32) -> vec4<u32> {
    return asides[slot];
}
