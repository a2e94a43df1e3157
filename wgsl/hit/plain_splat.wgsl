// Part `plain` of kernels whose casters are all of one simple kind: splats of the `filter` transfer, whose hits have the
// bits of wgsl/hit/gaussian.wgsl. CPU reference: src/reference/gaussian.rs.

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
    tilt: vec2<f32>,      // as in the setup
    start: vec3<f32>,     // e = x + tilt . (y u + z delta)
    spread: f32,
    distance: f32,        // along the axis of e = 1 [m]; in an orthographic view the light depth
    reach: f32,           // squared [standard deviations]
    amplitude: f32,       // opacity at the centre
    slope: f32,           // 1; 0 where nothing is to be seen
    absorbed: vec3<f32>,  // 1 - c
}

fn prepare(view: GpuView, footprint: Footprint) -> Plain {
    let setup = gaussian_setup(footprint);
    let place = footprint.place;
    let beside = PERSPECTIVE && is_beside(place);
    var splat: Plain;
    splat.center = place.xy;
    splat.whitening = setup.whitening;
    splat.tilt = setup.tilt;
    splat.reach = place.z * place.z;
    splat.amplitude = gaussian_amplitude(footprint);
    splat.slope = 1.0;
    splat.absorbed = 1.0 - vec3(unpack2x16unorm(setup.color.x), unpack2x16unorm(setup.color.y).x);
    splat.distance = place.w;
    if !PERSPECTIVE {
        return splat;
    }
    splat.spread = setup.spread;
    splat.start = vec3(1.0, 1.0, 0.0);
    splat.distance = view.near + place.w * (view.far - view.near);
    if beside {
        splat.center = view.size * 0.5;
        splat.offset = place.xy;
        splat.start = vec3(place.w, 0.0, 1.0);
        splat.distance = 1.0;
    }
    return splat;
}

// That of lane `lane` of the subgroup.
fn broadcast(splat: Plain, lane: u32) -> Plain {
    var other: Plain;
    other.center = subgroupShuffle(splat.center, lane);
    other.whitening = subgroupShuffle(splat.whitening, lane);
    other.tilt = subgroupShuffle(splat.tilt, lane);
    other.distance = subgroupShuffle(splat.distance, lane);
    other.amplitude = subgroupShuffle(splat.amplitude, lane);
    other.reach = subgroupShuffle(splat.reach, lane);
    other.slope = subgroupShuffle(splat.slope, lane);
    other.absorbed = subgroupShuffle(splat.absorbed, lane);
    if PERSPECTIVE {
        other.offset = subgroupShuffle(splat.offset, lane);
        other.spread = subgroupShuffle(splat.spread, lane);
        other.start = subgroupShuffle(splat.start, lane);
    }
    return other;
}

// Whether it may touch texel centres in the box lo..hi.
fn plain_touches(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return gaussian_touches(view, gaussian_setup(footprint), footprint.place, lo, hi);
}

// Profiles of four texels in a column, `dx` and `dy` from the centre.
fn rows_profile(view: GpuView, splat: Plain, dx: f32, dy: vec4<f32>, opaque: vec4<f32>) -> Profile4 {
    // Operation by operation as `approach`: the same bits.
    var x = splat.whitening.x * dx + splat.whitening.y * dy;
    var y = splat.whitening.z * dy;
    var squared = x * x + y * y;
    var depth = splat.distance - (splat.tilt.x * x + splat.tilt.y * y);
    if PERSPECTIVE {
        x += splat.offset.x;
        y += splat.offset.y;
        let along_x = splat.start.y * x + splat.start.z * dx;
        let along_y = splat.start.y * y + splat.start.z * dy;
        let ahead = splat.start.x + (splat.tilt.x * along_x + splat.tilt.y * along_y);
        let across = x * x + y * y;
        let all = ahead * ahead + splat.spread * across;
        squared = across / all;
        depth = (splat.distance * ahead / all - view.near) / (view.far - view.near);
    }
    let end = select(vec4(1.0), opaque, HAS_OPAQUE);
    let hits = (squared <= vec4(splat.reach)) & (depth >= vec4(0.0)) & (depth < end);
    let opacity = min(splat.amplitude * exp(-0.5 * squared), vec4(1.0));
    return Profile4(select(vec4(0.0), opacity, hits), depth);
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
