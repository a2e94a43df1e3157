// Volumes on the rays of an invocation's texels, face by face, as ramps. CPU reference:
// src/reference/curve/volumes.rs.

import package::curve::lights::{
    Lights, black, difference, plus, quotient, scaled, selected, times, white, with_light,
};
import package::curve::list::disordered;
import package::features::{HAS_GAIN, HAS_VOLUMES, unrolled};
import package::sums::sums::{MAX_TAU, light};
import choice::rows::{ROW_COUNT, RowIs, Rows, count_rows, row, with_row};

const MIN_TAU: f32 = 0.0000152587890625; // least optical depth of a ramp: 2^-16
// Rounding between light as fixed-point sums and as products: smaller differences are ignored.
const ROUNDING: f32 = 0.00048828125;

// Optical depth per light depth inside the volumes, behind `last_face`. Negative if a body was left that
// was not entered: the light is inside, or the entry comes late.
var<private> density: Lights;
var<private> last_face: Rows;
// Sums over all faces, as in nearest-depth mode.
var<private> crossed: array<vec4<i32>, ROW_COUNT>;
// Light that passes all hits except volumes, and the scale of their affine transfer.
var<private> surface_light: Lights;
var<private> surface_scale: Lights;

struct Ramp {
    start: Rows,
    end: Rows,
    light: Lights,
    is: RowIs,
}

fn clear_volumes() {
    density = black();
    last_face = Rows(0.0);
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        crossed[i] = vec4(0);
    }
    surface_light = white();
    surface_scale = white();
}

fn stretch_light(tau: Rows) -> Rows {
    return exp(-max(tau, Rows(-MAX_TAU)));
}

// Continues the volumes to light depth `depth`, and changes their densities there. The ramps end there; for late faces they are the effect of
// the change up to the last face.
fn change_density(depth: Rows, change: Lights) -> Ramp {
    let late = depth < last_face;
    let start = min(last_face, depth);
    let end = max(last_face, depth);
    let tau = times(selected(density, change, late), end - start);
    let is = difference(tau, black()) >= Rows(MIN_TAU);
    density = plus(density, change);
    // What is too thin for a ramp goes into the next.
    last_face = select(last_face, end, is | (difference(change, black()) > Rows(0.0)));
    return Ramp(
        start,
        end,
        Lights(stretch_light(tau.red), stretch_light(tau.green), stretch_light(tau.blue)),
        is,
    );
}

// Adds the volumes that were left but never entered: they contain the light, and begin at light depth 0.
fn begin_inside() -> Ramp {
    return change_density(
        Rows(0.0),
        Lights(max(-density.red, Rows(0.0)), max(-density.green, Rows(0.0)), max(-density.blue, Rows(0.0))),
    );
}

// Continues the volumes through the next segment; call it before appending that segment's curve.
fn follow_inside(next: Lights, next_last: Rows) -> Ramp {
    return change_density(max(last_face, next_last), next);
}

// Counts ramps that brighten: behind late faces the curve was too dark.
fn count_late(ramp: Ramp) {
    let light = max(max(ramp.light.red, ramp.light.green), ramp.light.blue);
    disordered += count_rows(ramp.is & (light > Rows(1.0)));
}

// Steps behind all pairs: volumes that contain the light, and overflowing casters.
fn rest_steps() -> u32 {
    return select(1u, 2u, HAS_VOLUMES);
}

fn volumes_light(tau: vec3<i32>) -> vec3<f32> {
    return light(bitcast<vec3<u32>>(select(max(tau, vec3(0)), tau, vec3(HAS_GAIN))));
}

// Transmittance to insert behind the curves: `is` is that of all insertions, `rest` the sums of overflowing
// casters.
fn rest_of_volumes(is: Lights, rest: array<vec3<i32>, ROW_COUNT>) -> Lights {
    var remaining = rest;
    var sums = white();
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        sums = with_light(sums, i, volumes_light(crossed[i].xyz + remaining[i]));
    }
    let behind = quotient(scaled(surface_light, sums), is, 1e-9);
    return selected(white(), behind, difference(behind, white()) >= Rows(ROUNDING));
}

// 0 if the light is inside a volume.
fn nearest_inside(nearest: Rows) -> Rows {
    var inside = nearest;
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        inside = with_row(inside, i, select(row(nearest, i), 0.0, crossed[i].w > 0));
    }
    return inside;
}
