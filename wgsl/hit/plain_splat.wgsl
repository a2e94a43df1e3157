// Part `plain` of kernels whose casters are all of one simple kind: splats of the `filter` transfer. CPU reference:
// src/reference/gaussian.rs.

import package::features::{HAS_OPAQUE, PERSPECTIVE};
import package::hit::disc::Profile4;
import package::hit::gaussian::{WIDER, gaussian_touches};
import package::records::footprint::Footprint;
import package::records::gaussian::{gaussian_amplitude, gaussian_setup};
import package::records::tile_rect::SLACK;
import package::records::view::{GpuView, is_beside};

// Root of log2(e) / 2: exp(-q^2 / 2) is the power of two of -(ROOT_LOG q)^2.
const ROOT_LOG: f32 = 0.84932184;
const UNSEEN_LOG: f32 = -200.0; // logarithm to base 2 of an opacity that is 0 everywhere

// The search for the nearest depth is a small share of a visit: a loop without it costs more than it saves.
const SEEKS_APART: bool = false;

struct Plain {
    center: vec2<f32>,    // [texels]; for one beside the view the map's centre
    whitening: vec3<f32>, // [1/texels]; in an orthographic view times ROOT_LOG
    offset: vec2<f32>,    // of the whitened position; for one beside the view
    tilt: vec2<f32>,      // as in the setup; in an orthographic view change of the light depth [1/texels]
    start: vec3<f32>,     // e = x + tilt . (y u + z delta)
    spread: f32,          // in an orthographic view how the ratio of neighbours changes along a column
    distance: f32,        // along the axis of e = 1 [m]; in an orthographic view the light depth
    reach: f32,           // squared [standard deviations]; in an orthographic view the opacity there
    amplitude: f32,       // opacity at the centre; in an orthographic view its logarithm to base 2
    absorbed: vec3<f32>,  // 1 - c
}

fn prepare(view: GpuView, footprint: Footprint) -> Plain {
    let setup = gaussian_setup(footprint);
    let bounds = footprint.bounds;
    let beside = PERSPECTIVE && is_beside(bounds);
    var splat: Plain;
    splat.center = bounds.xy;
    splat.whitening = setup.whitening;
    splat.tilt = setup.tilt;
    splat.reach = bounds.z * bounds.z;
    splat.amplitude = gaussian_amplitude(footprint);
    splat.absorbed = 1.0 - vec3(unpack2x16unorm(setup.color.x), unpack2x16unorm(setup.color.y).x);
    splat.distance = bounds.w;
    if !PERSPECTIVE {
        let w = setup.whitening;
        splat.whitening = w * ROOT_LOG;
        splat.tilt = vec2(-setup.tilt.x * w.x, -(setup.tilt.x * w.y + setup.tilt.y * w.z));
        splat.reach = splat.amplitude * exp(-0.5 * splat.reach);
        splat.amplitude = log2(splat.amplitude);
        splat.spread = exp2(-2.0 * dot(splat.whitening.yz, splat.whitening.yz));
        return splat;
    }
    splat.spread = setup.spread;
    splat.start = vec3(1.0, 1.0, 0.0);
    splat.distance = view.near + bounds.w * (view.far - view.near);
    if beside {
        splat.center = view.size * 0.5;
        splat.offset = bounds.xy;
        splat.start = vec3(bounds.w, 0.0, 1.0);
        splat.distance = 1.0;
    }
    return splat;
}

// The same, or one that nothing is to be seen of.
fn only_if(is_there: bool, plain: Plain) -> Plain {
    var splat = plain;
    splat.amplitude = select(select(UNSEEN_LOG, 0.0, PERSPECTIVE), splat.amplitude, is_there);
    return splat;
}

fn presence(plain: Plain, profile: vec4<f32>) -> vec4<f32> {
    return profile;
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
    other.absorbed = subgroupShuffle(splat.absorbed, lane);
    other.spread = subgroupShuffle(splat.spread, lane);
    if PERSPECTIVE {
        other.offset = subgroupShuffle(splat.offset, lane);
        other.start = subgroupShuffle(splat.start, lane);
    }
    return other;
}

// Whether it may touch texel centres in the box lo..hi.
fn plain_touches(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let setup = gaussian_setup(footprint);
    let bounds = footprint.bounds;
    if PERSPECTIVE {
        return gaussian_touches(view, setup, bounds, lo, hi);
    }
    // As there, where e is 1.
    let w = setup.whitening;
    let low = lo - SLACK - bounds.xy;
    let high = hi + SLACK - bounds.xy;
    let near = clamp(vec2(0.0), low, high);
    let along_x = clamp(-w.y / w.x * near.y, low.x, high.x);
    let along_y = clamp(-w.x * w.y / (w.y * w.y + w.z * w.z) * near.x, low.y, high.y);
    let x = vec2(along_x, near.x);
    let y = vec2(near.y, along_y);
    let u = w.x * x + w.y * y;
    let v = w.z * y;
    let squares = u * u + v * v;
    // Written so that a NaN touches.
    return !(min(squares.x, squares.y) > bounds.z * bounds.z * WIDER);
}

// Profiles of four texels in a column of a perspective view, `dx` and `dy` from the centre.
fn rows_profile(view: GpuView, splat: Plain, dx: f32, dy: vec4<f32>, opaque: vec4<f32>) -> Profile4 {
    // Operation by operation as `approach`: the same bits.
    let x = splat.whitening.x * dx + splat.whitening.y * dy + splat.offset.x;
    let y = splat.whitening.z * dy + splat.offset.y;
    let along_x = splat.start.y * x + splat.start.z * dx;
    let along_y = splat.start.y * y + splat.start.z * dy;
    let ahead = splat.start.x + (splat.tilt.x * along_x + splat.tilt.y * along_y);
    let across = x * x + y * y;
    let all = ahead * ahead + splat.spread * across;
    let squared = across / all;
    let depth = (splat.distance * ahead / all - view.near) / (view.far - view.near);
    let end = select(vec4(1.0), opaque, HAS_OPAQUE);
    let hits = (squared <= vec4(splat.reach)) & (depth >= vec4(0.0)) & (depth < end);
    let opacity = min(splat.amplitude * exp(-0.5 * squared), vec4(1.0));
    return Profile4(select(vec4(0.0), opacity, hits), depth);
}

// Profiles of four texels in a column of an orthographic view.
fn found(splat: Plain, opacity: vec4<f32>, depth: vec4<f32>, opaque: vec4<f32>) -> Profile4 {
    let end = select(vec4(1.0), opaque, HAS_OPAQUE);
    let hits = (opacity >= vec4(splat.reach)) & (depth >= vec4(0.0)) & (depth < end);
    return Profile4(select(vec4(0.0), opacity, hits), depth);
}

// Profiles of eight texels in a column; `first`: centre of the first.
fn column_profile(
    view: GpuView,
    splat: Plain,
    first: vec2<f32>,
    below: f32,
    opaque: array<vec4<f32>, 2>,
) -> array<Profile4, 2> {
    let dx = first.x - splat.center.x;
    let dy = first.y - splat.center.y + vec4(0.0, 1.0, 2.0, 3.0);
    if PERSPECTIVE {
        return array(
            rows_profile(view, splat, dx, dy, opaque[0]),
            rows_profile(view, splat, dx, dy + 4.0, opaque[1]),
        );
    }
    // A column of a Gaussian: the ratio of neighbours changes by the same ratio from one to the next. From the
    // fourth texel on both ways: what lies farther is so little that its rounding, or that it is 0, does not matter.
    let w = splat.whitening;
    let x = w.x * dx + w.y * dy.w;
    let y = w.z * dy.w;
    let change = splat.spread;
    let up = exp2(2.0 * (w.y * x + w.z * y) - (w.y * w.y + w.z * w.z));
    let down = change / up;
    let middle = exp2(splat.amplitude - (x * x + y * y));
    let up1 = up * change;
    let down1 = down * change;
    let down2 = down1 * change;
    let c = middle * up;
    let b = c * up1;
    let a = b * (up1 * change);
    let e = middle * down;
    let f = e * down1;
    let g = f * down2;
    let h = g * (down2 * change);
    let depth = splat.distance + splat.tilt.x * dx + splat.tilt.y * dy;
    return array(
        found(splat, vec4(a, b, c, middle), depth, opaque[0]),
        found(splat, vec4(e, f, g, h), depth + splat.tilt.y * 4.0, opaque[1]),
    );
}
