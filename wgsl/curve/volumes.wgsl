// Volumes on the rays of four texels, face by face, as ramps. CPU reference: src/reference/curve/volumes.rs.

import package::curve::light4::{Light4, black4, light4, plus, quotient, scaled, selected, white4};
import package::curve::list::disordered;
import package::features::{HAS_GAIN, HAS_VOLUMES};
import package::sums::sums::{MAX_TAU, light};

const MIN_TAU: f32 = 0.0000152587890625; // least optical depth of a ramp: 2^-16
// Rounding between light as fixed-point sums and as products: smaller differences are ignored.
const ROUNDING: f32 = 0.00048828125;

// Optical depth per light depth inside the volumes, behind `last_face`. Negative if a body was left that
// was not entered: the light is inside, or the entry comes late.
var<private> density: Light4;
var<private> last_face: vec4<f32>;
// Sums over all faces, as in nearest-depth mode.
var<private> crossed: array<vec4<i32>, 4>;
// Light that passes all hits except volumes, and the scale of their affine transfer.
var<private> surface_light: Light4;
var<private> surface_scale: Light4;

struct Ramp4 {
    start: vec4<f32>,
    end: vec4<f32>,
    light: Light4,
    is: vec4<bool>,
}

fn clear_volumes() {
    density = black4();
    last_face = vec4(0.0);
    crossed = array(vec4(0), vec4(0), vec4(0), vec4(0));
    surface_light = white4();
    surface_scale = white4();
}

fn times(a: Light4, b: vec4<f32>) -> Light4 {
    return Light4(a.red * b, a.green * b, a.blue * b);
}

fn stretch_light(tau: vec4<f32>) -> vec4<f32> {
    return exp(-max(tau, vec4(-MAX_TAU)));
}

// Changes the densities at light depth `depth`. The ramps end there; for late faces they are the effect of
// the change up to the last face.
fn change_density(depth: vec4<f32>, change: Light4) -> Ramp4 {
    let late = depth < last_face;
    let start = min(last_face, depth);
    let end = max(last_face, depth);
    let tau = times(selected(density, change, late), end - start);
    density = plus(density, change);
    last_face = end;
    let most = max(max(abs(tau.red), abs(tau.green)), abs(tau.blue));
    return Ramp4(
        start,
        end,
        Light4(stretch_light(tau.red), stretch_light(tau.green), stretch_light(tau.blue)),
        most >= vec4(MIN_TAU),
    );
}

// Adds the volumes that were left but never entered: they contain the light, and begin at light depth 0.
fn begin_inside() -> Ramp4 {
    return change_density(
        vec4(0.0),
        Light4(max(-density.red, vec4(0.0)), max(-density.green, vec4(0.0)), max(-density.blue, vec4(0.0))),
    );
}

// Continues the volumes through the next segment; call it before appending that segment's curve.
fn follow_inside(next: Light4, next_last: vec4<f32>) -> Ramp4 {
    return change_density(max(last_face, next_last), next);
}

// Counts ramps that brighten: behind late faces the curve was too dark.
fn count_late(ramp: Ramp4) {
    let light = max(max(ramp.light.red, ramp.light.green), ramp.light.blue);
    disordered += dot(vec4<u32>(ramp.is & (light > vec4(1.0))), vec4(1u));
}

// Steps behind all pairs: volumes that contain the light, and overflowing casters.
fn rest_steps() -> u32 {
    return select(1u, 2u, HAS_VOLUMES);
}

fn volumes_light(i: u32, rest: vec3<i32>) -> vec3<f32> {
    let tau = crossed[i].xyz + rest;
    return light(bitcast<vec3<u32>>(select(max(tau, vec3(0)), tau, vec3(HAS_GAIN))));
}

// Transmittance to insert behind the curves: `is` is that of all insertions, `rest` the sums of overflowing
// casters.
fn rest_of_volumes(is: Light4, rest: array<vec3<i32>, 4>) -> Light4 {
    let sums = light4(
        volumes_light(0u, rest[0]),
        volumes_light(1u, rest[1]),
        volumes_light(2u, rest[2]),
        volumes_light(3u, rest[3]),
    );
    let own = quotient(scaled(surface_light, sums), is, 1e-9);
    let apart = max(max(abs(own.red - 1.0), abs(own.green - 1.0)), abs(own.blue - 1.0));
    return selected(white4(), own, apart >= vec4(ROUNDING));
}

// 0 if the light is inside a volume.
fn nearest_inside(nearest: vec4<f32>) -> vec4<f32> {
    let leaves = vec4(crossed[0].w, crossed[1].w, crossed[2].w, crossed[3].w);
    return select(nearest, vec4(0.0), leaves > vec4(0));
}
