// Volumes on the ray of a texel, face by face, as ramps. CPU reference:
// crates/gobo-reference/src/curve/volumes.rs.

import package::curve::gather::Texel;
import package::curve::list::disordered;
import package::features::{HAS_GAIN, HAS_VOLUMES};
import package::sums::sums::{MAX_TAU, light};

const MIN_TAU: f32 = 0.0000152587890625; // least optical depth of a ramp: 2^-16
// Differences that are ignored: rounding between light as fixed-point sums and as products.
const ROUNDING: f32 = 0.00048828125;

// Volumes that were left and not entered: the light is inside, or the entry comes late.
struct Unentered {
    density: vec3<f32>, // optical depth per light depth
    tau: vec3<f32>,     // optical depth from light depth 0 to where they were left
    first: f32,         // light depths of the first and the last place where one was left
    last: f32,
}

struct Ramp {
    start: f32,
    end: f32,
    light: vec3<f32>,
    is: bool,
}

// The largest size in any channel.
fn largest(v: vec3<f32>) -> f32 {
    return max(max(abs(v.r), abs(v.g)), abs(v.b));
}

fn ramp_of(start: f32, end: f32, tau: vec3<f32>) -> Ramp {
    return Ramp(start, end, exp(-max(tau, vec3(-MAX_TAU))), largest(tau) >= MIN_TAU);
}

// Mean light depth where volumes were left.
fn mean_ends(left: Unentered) -> vec3<f32> {
    return left.tau / max(left.density, vec3(1.17549435e-38));
}

fn add_unentered(t: ptr<function, Texel>, added: vec3<f32>, ends: vec3<f32>, first: f32, last: f32) {
    let so_far = (*t).unentered;
    let is = largest(added) > 0.0;
    let is_first = largest(so_far.density) <= 0.0;
    (*t).unentered = Unentered(
        so_far.density + added,
        so_far.tau + added * ends,
        select(so_far.first, select(min(so_far.first, first), first, is_first), is),
        select(so_far.last, max(so_far.last, last), is),
    );
}

// Continues the volumes to light depth `depth`, and changes their densities there. Returns their ramps, which
// end there; for a late face, the effect of the change up to the last face.
fn change_density(t: ptr<function, Texel>, depth: f32, change: vec3<f32>) -> Ramp {
    let texel = *t;
    let late = depth < texel.last_face;
    let start = min(texel.last_face, depth);
    let end = max(texel.last_face, depth);
    // An entry in front of such a place belongs to the volume that was left there.
    let ends = mean_ends(texel.unentered);
    let belongs = min(max(change, vec3(0.0)), texel.unentered.density);
    let entered = select(vec3(0.0), belongs, depth < texel.unentered.last);
    (*t).unentered.density -= entered;
    (*t).unentered.tau -= entered * ends;
    let balance = texel.density + change - entered;
    add_unentered(t, max(-balance, vec3(0.0)), vec3(depth), depth, depth);
    let behind = max(balance, vec3(0.0));
    let acting = select(texel.density, behind - texel.density, late);
    let ramp = ramp_of(start, end, acting * (end - start) + entered * (ends - depth));
    (*t).density = behind;
    // A stretch too thin for a ramp goes into the next.
    (*t).last_face = select(texel.last_face, end, ramp.is | (largest(change) > 0.0));
    return ramp;
}

// Ramp of the volumes that were left but never entered: they contain the light, and begin at light depth 0.
// One reaches to the first place where a volume was left, one from there to the last: exact for two volumes.
fn begin_inside(left: Unentered, part: u32) -> Ramp {
    let near = left.density * left.first;
    if part == 0u {
        return ramp_of(0.0, left.first, near);
    }
    return ramp_of(left.first, left.last, left.tau - near);
}

// Continues the volumes through the next segment, before that segment's curve is appended.
fn follow_inside(
    t: ptr<function, Texel>,
    next_density: vec3<f32>,
    next_last: f32,
    next: Unentered,
) -> Ramp {
    let texel = *t;
    let start = texel.last_face;
    let end = max(start, next_last);
    let left = min(next.density, texel.density);
    let ends = mean_ends(next);
    let tau = texel.density * (end - start) - left * (end - ends);
    add_unentered(t, next.density - left, ends, next.first, next.last);
    (*t).density = texel.density + (next_density - left);
    (*t).last_face = end;
    return ramp_of(start, end, tau);
}

// Counts ramps that brighten: behind late faces, where the curve was too dark.
fn count_late(ramp: Ramp) {
    disordered += u32(ramp.is & (largest(ramp.light) > 1.0));
}

// Steps behind all pairs: two for volumes that contain the light, one for scattered casters.
fn rest_steps() -> u32 {
    return select(1u, 3u, HAS_VOLUMES);
}

// Transmittance to insert behind a curve. `is`: transmittance of all insertions; `surfaces`: of all hits
// except volumes; `tau`: sums of the volumes and of the scattered casters.
fn rest_of_volumes(is: vec3<f32>, surfaces: vec3<f32>, tau: vec3<i32>) -> vec3<f32> {
    let sums = light(bitcast<vec3<u32>>(select(max(tau, vec3(0)), tau, vec3(HAS_GAIN))));
    let behind = surfaces * sums / max(is, vec3(1e-9));
    return select(vec3(1.0), behind, largest(behind - 1.0) >= ROUNDING);
}
