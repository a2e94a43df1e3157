// Scattered casters, whose pairs fit neither the budget nor the recorded parts of the tiles, as one hit
// behind all others: pairs get capacity front to back. Resets the sums to zero. CPU reference:
// crates/gobo-reference/src/curve/tile.rs.

import package::curve::lights::{Lights, white, with_light};
import package::curve::volumes::rest_of_volumes;
import package::features::{HAS_VOLUMES, unrolled};
import package::records::view::TILE_SIZE;
import package::sums::sums::{light, nearness_to_depth};
import choice::rows::{ROW_COUNT, RowIs, Rows, with_row};
import choice::sums::{clear_sums, load_nearness, load_sums};

struct Overflowed {
    sums: array<vec3<i32>, ROW_COUNT>,
    light: Lights,
    depth: Rows, // of the nearest visible caster, 1 for none
}

fn nothing_overflowed() -> Overflowed {
    return Overflowed(array<vec3<i32>, ROW_COUNT>(), white(), Rows(1.0));
}

// `is_any`: whether the tile has scattered casters. A loop of one turn, because software adapters take both
// sides of a branch.
fn overflowed(first_sum: u32, is_any: bool) -> Overflowed {
    var rest = nothing_overflowed();
    for (var turn = 0u; turn < u32(is_any); turn += 1u) {
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            let sum = first_sum + i * TILE_SIZE;
            let sums = load_sums(sum);
            rest.sums[i] = bitcast<vec3<i32>>(sums);
            rest.light = with_light(rest.light, i, light(sums));
            rest.depth = with_row(rest.depth, i, nearness_to_depth(load_nearness(sum)));
            clear_sums(sum);
        }
    }
    return rest;
}

// Transmittance to insert behind curves of transmittance `is`.
fn rest_light(rest: Overflowed, is: Lights) -> Lights {
    if HAS_VOLUMES {
        return rest_of_volumes(is, rest.sums);
    }
    return rest.light;
}

// Where the light differs from white.
fn is_light(light: Lights) -> RowIs {
    return (light.red != Rows(1.0)) | (light.green != Rows(1.0)) | (light.blue != Rows(1.0));
}
