// Scattered casters, whose pairs fit neither the budget nor the recorded parts of the tiles, as one hit
// behind all others: pairs get capacity front to back. Resets the sums to zero. CPU reference:
// crates/gobo-reference/src/curve/tile.rs.

import package::curve::gather::Texel;
import package::curve::volumes::rest_of_volumes;
import package::features::HAS_VOLUMES;
import package::sums::sums::{light, nearness_to_depth};
import choice::sums::{clear_sums, load_nearness, load_sums};

struct Overflowed {
    sums: vec3<u32>,
    depth: f32, // of the nearest visible caster, 1 for none
}

// `is_any`: whether the tile has scattered casters. A loop of one turn, because software adapters take both
// sides of a branch.
fn overflowed(sum: u32, is_any: bool) -> Overflowed {
    var rest = Overflowed(vec3(0u), 1.0);
    for (var turn = 0u; turn < u32(is_any); turn += 1u) {
        rest = Overflowed(load_sums(sum), nearness_to_depth(load_nearness(sum)));
        clear_sums(sum);
    }
    return rest;
}

// Transmittance to insert behind a curve of transmittance `is`.
fn rest_light(texel: Texel, rest: Overflowed, is: vec3<f32>) -> vec3<f32> {
    if HAS_VOLUMES {
        return rest_of_volumes(is, texel.surface_light, texel.crossed.xyz + bitcast<vec3<i32>>(rest.sums));
    }
    return light(rest.sums);
}
