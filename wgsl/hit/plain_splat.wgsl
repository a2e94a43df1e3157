// Part `plain` of kernels whose casters are all splats of the `filter` transfer. CPU reference:
// crates/gobo-reference/src/gaussian.rs.

import package::features::{HAS_OPAQUE, PERSPECTIVE};
import package::hit::gaussian::{WIDER, gaussian_touches};
import package::records::caster::{gaussian_amplitude, gaussian_setup};
import package::records::footprint::Footprint;
import package::records::pack::unpack_absorbed;
import package::records::tile::SLACK;
import package::records::view::{GpuView, is_beside};

// Root of log2(e) / 2: exp(-q^2 / 2) = exp2(-(ROOT_LOG q)^2).
const ROOT_LOG: f32 = 0.84932184;
const UNSEEN_LOG: f32 = -200.0; // logarithm to base 2 of an opacity that is 0 everywhere

// The search for the nearest depth is a small share of a visit: a loop without it costs more than it saves.
const SEEKS_APART: bool = false;

struct Plain {
    center: vec2<f32>,    // [texels]; for a splat beside the view the map's centre
    whitening: vec3<f32>, // [1/texels]; in an orthographic view times ROOT_LOG
    offset: vec2<f32>,    // of the whitened position; 0 but for a splat beside the view
    tilt: vec2<f32>,      // as in the setup; in an orthographic view change of the light depth [1/texels]
    start: vec3<f32>,     // e = x + tilt . (y u + z delta)
    spread: f32,          // as in the setup
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
    splat.absorbed = unpack_absorbed(setup.color);
    splat.distance = bounds.w;
    if !PERSPECTIVE {
        let w = setup.whitening;
        splat.whitening = w * ROOT_LOG;
        splat.tilt = vec2(-setup.tilt.x * w.x, -(setup.tilt.x * w.y + setup.tilt.y * w.z));
        splat.reach = splat.amplitude * exp(-0.5 * splat.reach);
        splat.amplitude = log2(splat.amplitude);
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

// The splat, or one that does nothing.
fn only_if(is_there: bool, plain: Plain) -> Plain {
    var splat = plain;
    splat.amplitude = select(select(UNSEEN_LOG, 0.0, PERSPECTIVE), splat.amplitude, is_there);
    return splat;
}

// Opacity and light depth.
struct PlainHit {
    profile: f32,
    depth: f32,
}

fn presence(plain: Plain, hit: PlainHit) -> f32 {
    return hit.profile;
}

// The splat of lane `lane` of the subgroup.
fn broadcast(splat: Plain, lane: u32) -> Plain {
    var other: Plain;
    other.center = subgroupShuffle(splat.center, lane);
    other.whitening = subgroupShuffle(splat.whitening, lane);
    other.tilt = subgroupShuffle(splat.tilt, lane);
    other.distance = subgroupShuffle(splat.distance, lane);
    other.amplitude = subgroupShuffle(splat.amplitude, lane);
    other.reach = subgroupShuffle(splat.reach, lane);
    other.absorbed = subgroupShuffle(splat.absorbed, lane);
    if PERSPECTIVE {
        other.spread = subgroupShuffle(splat.spread, lane);
        other.offset = subgroupShuffle(splat.offset, lane);
        other.start = subgroupShuffle(splat.start, lane);
    }
    return other;
}

// Whether the splat may touch texel centres in the box lo..hi.
fn plain_touches(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let setup = gaussian_setup(footprint);
    let bounds = footprint.bounds;
    if PERSPECTIVE {
        return gaussian_touches(view, setup, bounds, lo, hi);
    }
    // As in `gaussian_touches`, with e = 1.
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

// `delta`: from the splat's centre [texels].
fn plain_hit(view: GpuView, splat: Plain, delta: vec2<f32>, opaque: f32) -> PlainHit {
    let end = select(1.0, opaque, HAS_OPAQUE);
    // Operation by operation as `approach`: the same bits.
    let x = splat.whitening.x * delta.x + splat.whitening.y * delta.y + splat.offset.x;
    let y = splat.whitening.z * delta.y + splat.offset.y;
    if !PERSPECTIVE {
        let opacity = exp2(splat.amplitude - (x * x + y * y));
        let depth = splat.distance + splat.tilt.x * delta.x + splat.tilt.y * delta.y;
        let hits = opacity >= splat.reach && depth >= 0.0 && depth < end;
        return PlainHit(select(0.0, opacity, hits), depth);
    }
    let along = splat.start.y * vec2(x, y) + splat.start.z * delta;
    let ahead = splat.start.x + (splat.tilt.x * along.x + splat.tilt.y * along.y);
    let across = x * x + y * y;
    let all = ahead * ahead + splat.spread * across;
    let squared = across / all;
    let depth = (splat.distance * ahead / all - view.near) / (view.far - view.near);
    let hits = squared <= splat.reach && depth >= 0.0 && depth < end;
    return PlainHit(select(0.0, min(splat.amplitude * exp(-0.5 * squared), 1.0), hits), depth);
}
