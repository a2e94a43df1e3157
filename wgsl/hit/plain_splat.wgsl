// Part `plain` of kernels whose casters are all of one simple kind: splats of the `filter` transfer. The form of
// `approach` (wgsl/hit/gaussian.wgsl) with what is linear in the texel's place set up once. CPU reference:
// src/reference/gaussian.rs.

import package::features::{HAS_OPAQUE, PERSPECTIVE};
import package::hit::disc::Profile4;
import package::hit::gaussian::gaussian_touches;
import package::records::footprint::Footprint;
import package::records::gaussian::{gaussian_amplitude, gaussian_setup};
import package::records::view::{GpuView, is_beside};

struct Plain {
    center: vec2<f32>,    // [texels]; for one beside the view the map's centre
    whitening: vec3<f32>, // [1/texels]
    offset: vec2<f32>,    // of the whitened place; for one beside the view
    ahead: vec3<f32>,     // e = x + y delta.x + z delta.y; in an orthographic view the light depth
    spread: f32,
    distance: f32,        // light depth of e = 1 less that of the eye
    reach: f32,           // squared [standard deviations]
    slope: f32,           // opacity at the centre
    absorbed: vec3<f32>,  // slope (1 - c)
}

fn prepare(view: GpuView, footprint: Footprint) -> Plain {
    let setup = gaussian_setup(footprint);
    let place = footprint.place;
    let beside = PERSPECTIVE && is_beside(place);
    let w = setup.whitening;
    var tilt = vec2(setup.tilt.x * w.x, setup.tilt.x * w.y + setup.tilt.y * w.z);
    var splat: Plain;
    splat.center = place.xy;
    splat.whitening = w;
    splat.reach = place.z * place.z;
    splat.slope = min(gaussian_amplitude(footprint), 1.0);
    let blue = unpack2x16unorm(setup.color.y).x;
    splat.absorbed = splat.slope * (1.0 - vec3(unpack2x16unorm(setup.color.x), blue));
    if !PERSPECTIVE {
        splat.ahead = vec3(place.w, -tilt);
        return splat;
    }
    let range = view.far - view.near;
    splat.spread = setup.spread;
    splat.ahead = vec3(1.0, tilt);
    splat.distance = view.near / range + place.w;
    if beside {
        splat.center = view.size * 0.5;
        splat.offset = place.xy;
        splat.ahead = vec3(place.w, setup.tilt);
        splat.distance = 1.0 / range;
    }
    return splat;
}

// That of lane `lane` of the subgroup.
fn broadcast(splat: Plain, lane: u32) -> Plain {
    var other: Plain;
    other.center = subgroupShuffle(splat.center, lane);
    other.whitening = subgroupShuffle(splat.whitening, lane);
    other.ahead = subgroupShuffle(splat.ahead, lane);
    other.reach = subgroupShuffle(splat.reach, lane);
    other.slope = subgroupShuffle(splat.slope, lane);
    other.absorbed = subgroupShuffle(splat.absorbed, lane);
    if PERSPECTIVE {
        other.offset = subgroupShuffle(splat.offset, lane);
        other.spread = subgroupShuffle(splat.spread, lane);
        other.distance = subgroupShuffle(splat.distance, lane);
    }
    return other;
}

// Whether it may touch texel centres in the box lo..hi.
fn plain_touches(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return gaussian_touches(view, gaussian_setup(footprint), footprint.place, lo, hi);
}

// Profiles of four texels in a column, `dx` and `dy` from the centre.
fn rows_profile(view: GpuView, splat: Plain, dx: f32, dy: vec4<f32>, opaque: vec4<f32>) -> Profile4 {
    let x = (splat.offset.x + splat.whitening.x * dx) + splat.whitening.y * dy;
    let y = splat.offset.y + splat.whitening.z * dy;
    var squared = x * x + y * y;
    var depth = (splat.ahead.x + splat.ahead.y * dx) + splat.ahead.z * dy;
    if PERSPECTIVE {
        let share = 1.0 / (depth * depth + splat.spread * squared);
        squared *= share;
        depth = splat.distance * depth * share - view.near / (view.far - view.near);
    }
    let end = select(vec4(1.0), opaque, HAS_OPAQUE);
    let hits = (squared <= vec4(splat.reach)) & (depth >= vec4(0.0)) & (depth < end);
    return Profile4(select(vec4(0.0), exp(-0.5 * squared), hits), depth);
}

// Profiles of eight texels in a column; `first`: centre of the first.
fn column_profile(view: GpuView, splat: Plain, first: vec2<f32>, opaque: array<vec4<f32>, 2>) -> array<Profile4, 2> {
    let dx = first.x - splat.center.x;
    let dy = first.y - splat.center.y + vec4(0.0, 1.0, 2.0, 3.0);
    return array(
        rows_profile(view, splat, dx, dy, opaque[0]),
        rows_profile(view, splat, dx, dy + 4.0, opaque[1]),
    );
}
