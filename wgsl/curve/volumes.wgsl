// Volumes on the rays of an invocation's texels, face by face, as ramps. CPU reference:
// crates/gobo-reference/src/curve/volumes.rs.

import package::curve::lights::{
    Lights, black, difference, minus, plus, quotient, scaled, selected, times, white, with_light,
};
import package::curve::list::disordered;
import package::features::{HAS_GAIN, HAS_VOLUMES, unrolled};
import package::sums::sums::{MAX_TAU, light};
import choice::rows::{ROW_COUNT, RowIs, Rows, count_rows, row, with_row};

const MIN_TAU: f32 = 0.0000152587890625; // least optical depth of a ramp: 2^-16
// Differences that are ignored: rounding between light as fixed-point sums and as products.
const ROUNDING: f32 = 0.00048828125;

// Optical depth per light depth, behind `last_face`, of the volumes that were entered and not left.
var<private> density: Lights;
var<private> last_face: Rows;
var<private> unentered: Unentered;
// Sums over all faces, as in nearest-depth mode.
var<private> crossed: array<vec4<i32>, ROW_COUNT>;
// Light that passes all hits except volumes, and the scale of that affine transfer.
var<private> surface_light: Lights;
var<private> surface_scale: Lights;

// Volumes that were left and not entered: the light is inside, or the entry comes late.
struct Unentered {
    density: Lights, // optical depth per light depth
    tau: Lights,     // optical depth from light depth 0 to where they were left
    first: Rows,     // light depths of the first and the last place where one was left
    last: Rows,
}

struct Ramp {
    start: Rows,
    end: Rows,
    light: Lights,
    is: RowIs,
}

fn clear_volumes() {
    density = black();
    last_face = Rows(0.0);
    unentered = Unentered(black(), black(), Rows(0.0), Rows(0.0));
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        crossed[i] = vec4(0);
    }
    surface_light = white();
    surface_scale = white();
}

fn stretch_light(tau: Rows) -> Rows {
    return exp(-max(tau, Rows(-MAX_TAU)));
}

fn ramp_of(start: Rows, end: Rows, tau: Lights) -> Ramp {
    let light = Lights(stretch_light(tau.red), stretch_light(tau.green), stretch_light(tau.blue));
    return Ramp(start, end, light, difference(tau, black()) >= Rows(MIN_TAU));
}

fn positive(v: Lights) -> Lights {
    return Lights(max(v.red, Rows(0.0)), max(v.green, Rows(0.0)), max(v.blue, Rows(0.0)));
}

fn least(a: Lights, b: Lights) -> Lights {
    return Lights(min(a.red, b.red), min(a.green, b.green), min(a.blue, b.blue));
}

// Mean light depth where volumes were left.
fn mean_ends(left: Unentered) -> Lights {
    return quotient(left.tau, left.density, 1.17549435e-38);
}

fn add_unentered(added: Lights, ends: Lights, first: Rows, last: Rows) {
    let is = difference(added, black()) > Rows(0.0);
    let is_first = difference(unentered.density, black()) <= Rows(0.0);
    unentered.first = select(unentered.first, select(min(unentered.first, first), first, is_first), is);
    unentered.last = select(unentered.last, max(unentered.last, last), is);
    unentered.density = plus(unentered.density, added);
    unentered.tau = plus(unentered.tau, scaled(added, ends));
}

// Continues the volumes to light depth `depth`, and changes their densities there. Returns their ramps, which
// end there; for late faces, the effect of the change up to the last face.
fn change_density(depth: Rows, change: Lights) -> Ramp {
    let late = depth < last_face;
    let start = min(last_face, depth);
    let end = max(last_face, depth);
    // An entry in front of such a place belongs to the volume that was left there.
    let ends = mean_ends(unentered);
    let entered = selected(black(), least(positive(change), unentered.density), depth < unentered.last);
    let at = Lights(depth, depth, depth);
    unentered.density = minus(unentered.density, entered);
    unentered.tau = minus(unentered.tau, scaled(entered, ends));
    let balance = minus(plus(density, change), entered);
    add_unentered(positive(minus(black(), balance)), at, depth, depth);
    let behind = positive(balance);
    let acting = selected(density, minus(behind, density), late);
    let ramp = ramp_of(start, end, plus(times(acting, end - start), scaled(entered, minus(ends, at))));
    density = behind;
    // A stretch too thin for a ramp goes into the next.
    last_face = select(last_face, end, ramp.is | (difference(change, black()) > Rows(0.0)));
    return ramp;
}

// Ramps of the volumes that were left but never entered: they contain the light, and begin at light depth 0.
// One reaches to the first place where a volume was left, one from there to the last: exact for two volumes.
fn begin_inside(part: u32) -> Ramp {
    let near = times(unentered.density, unentered.first);
    if part == 0u {
        return ramp_of(Rows(0.0), unentered.first, near);
    }
    return ramp_of(unentered.first, unentered.last, minus(unentered.tau, near));
}

// Continues the volumes through the next segment, before that segment's curve is appended.
fn follow_inside(next_density: Lights, next_last: Rows, next: Unentered) -> Ramp {
    let start = last_face;
    let end = max(last_face, next_last);
    let left = least(next.density, density);
    let ends = mean_ends(next);
    let beyond = scaled(left, minus(Lights(end, end, end), ends));
    let tau = minus(times(density, end - start), beyond);
    add_unentered(minus(next.density, left), ends, next.first, next.last);
    density = plus(density, minus(next_density, left));
    last_face = end;
    return ramp_of(start, end, tau);
}

// Counts ramps that brighten: behind late faces, where the curve was too dark.
fn count_late(ramp: Ramp) {
    let light = max(max(ramp.light.red, ramp.light.green), ramp.light.blue);
    disordered += count_rows(ramp.is & (light > Rows(1.0)));
}

// Steps behind all pairs: two for volumes that contain the light, one for scattered casters.
fn rest_steps() -> u32 {
    return select(1u, 3u, HAS_VOLUMES);
}

fn volumes_light(tau: vec3<i32>) -> vec3<f32> {
    return light(bitcast<vec3<u32>>(select(max(tau, vec3(0)), tau, vec3(HAS_GAIN))));
}

// Transmittance to insert behind the curves. `is`: transmittance of all insertions; `rest`: sums of the
// scattered casters.
fn rest_of_volumes(is: Lights, rest: array<vec3<i32>, ROW_COUNT>) -> Lights {
    var remaining = rest;
    var sums = white();
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        sums = with_light(sums, i, volumes_light(crossed[i].xyz + remaining[i]));
    }
    let behind = quotient(scaled(surface_light, sums), is, 1e-9);
    return selected(white(), behind, difference(behind, white()) >= Rows(ROUNDING));
}

// Nearest depths: 0 where the light is inside a volume.
fn nearest_inside(nearest: Rows) -> Rows {
    var inside = nearest;
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        inside = with_row(inside, i, select(row(nearest, i), 0.0, crossed[i].w > 0));
    }
    return inside;
}
