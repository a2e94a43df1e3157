// Scattered casters, whose pairs fit neither the budget nor the parts of the tiles that were recorded, as one
// hit behind those that did: pairs get capacity front to back.
// Resets the sums to zero. CPU reference: src/reference/curve/tile.rs.

import package::curve::light4::{Light4, light4, white4};
import package::curve::volumes::rest_of_volumes;
import package::features::HAS_VOLUMES;
import package::records::view::TILE_SIZE;
import package::sums::sums::{light, nearness_to_depth};
import choice::sums::{clear_sums, load_nearness, load_sums};

struct Overflowed {
    sums: array<vec3<i32>, 4>,
    light: Light4,
    depth: vec4<f32>, // of the nearest visible one, 1 for none
}

fn nothing_overflowed() -> Overflowed {
    return Overflowed(array(vec3(0), vec3(0), vec3(0), vec3(0)), white4(), vec4(1.0));
}

fn overflowed(sum: u32) -> Overflowed {
    let a = overflowed_row(sum);
    let b = overflowed_row(sum + TILE_SIZE);
    let c = overflowed_row(sum + 2u * TILE_SIZE);
    let d = overflowed_row(sum + 3u * TILE_SIZE);
    return Overflowed(
        array(a.sums, b.sums, c.sums, d.sums),
        light4(row_light(a), row_light(b), row_light(c), row_light(d)),
        vec4(a.depth, b.depth, c.depth, d.depth),
    );
}

struct OverflowedRow {
    sums: vec3<i32>,
    depth: f32,
}

fn overflowed_row(sum: u32) -> OverflowedRow {
    let row = OverflowedRow(bitcast<vec3<i32>>(load_sums(sum)), nearness_to_depth(load_nearness(sum)));
    clear_sums(sum);
    return row;
}

fn row_light(row: OverflowedRow) -> vec3<f32> {
    return light(bitcast<vec3<u32>>(row.sums));
}

// Transmittance to insert behind curves of transmittance `is`.
fn rest_light(rest: Overflowed, is: Light4) -> Light4 {
    if HAS_VOLUMES {
        return rest_of_volumes(is, rest.sums);
    }
    return rest.light;
}

// Where the light differs from white.
fn is_light(light: Light4) -> vec4<bool> {
    return (light.red != vec4(1.0)) | (light.green != vec4(1.0)) | (light.blue != vec4(1.0));
}
