// Hit of a ray with a Gaussian. CPU reference: crates/gobo-reference/src/gaussian.rs.

import package::bind::uniform::materials;
import package::features::HAS_MEDIA;
import package::records::caster::{GaussianSetup, MEDIUM_BIT, gaussian_amplitude};
import package::records::footprint::Footprint;
import package::records::pack::unpack_color;
import package::records::record::OPACITY_SCALE;
import package::records::tile::SLACK;
import package::records::view::{GpuView, is_beside};
import package::sums::sums::tau_absorbed;

// A ray's closest approach, in the Gaussian's own space.
struct Approach {
    squared: f32,   // squared distance [standard deviations]
    depth: f32,     // light depth of that point
    deviation: f32, // along the ray [light depth]
    position: vec2<f32>, // whitened position
}

struct GaussianHit {
    color: vec3<f32>,
    thin: f32, // ratio of the Gaussian's area to its projected, enlarged one
    opacity: f32,
    start: f32, // light depth; -1 for a miss
    end: f32,
}

const WIDER: f32 = 1.001; // factor of the squared reach in tests against boxes, for rounding
const AT_THE_END: f32 = 0.25; // distance of a medium's ramp from the ray's end, at least [deviations]
const FARTHEST_TAIL: f32 = 8.0; // beyond which a medium absorbs nothing [deviations]

fn approach(view: GpuView, footprint: Footprint, setup: GaussianSetup, texel: vec2<f32>) -> Approach {
    let bounds = footprint.bounds;
    let beside = is_beside(bounds);
    let range = view.far - view.near;
    let delta = texel - select(bounds.xy, view.size * 0.5, beside);
    let w = setup.whitening;
    var u = vec2(w.x * delta.x + w.y * delta.y, w.z * delta.y);
    if view.perspective == 0.0 {
        return Approach(dot(u, u), bounds.w - dot(setup.tilt, u), sqrt(setup.spread), u);
    }
    u += select(vec2(0.0), bounds.xy, beside);
    let ahead = select(1.0 + dot(setup.tilt, u), bounds.w + dot(setup.tilt, delta), beside);
    let unit = select(view.near + bounds.w * range, 1.0, beside);
    let across = dot(u, u);
    let all = ahead * ahead + setup.spread * across;
    return Approach(
        across / all,
        (unit * ahead / all - view.near) / range,
        unit * sqrt(setup.spread / all) / range,
        u,
    );
}

// Whether some texel centre in the box lo..hi may be within the footprint's end: the conic is convex and
// contains the centre, so if it touches the box, it touches an edge that faces the centre.
fn gaussian_touches(
    view: GpuView,
    setup: GaussianSetup,
    bounds: vec4<f32>,
    lo: vec2<f32>,
    hi: vec2<f32>,
) -> bool {
    let squared = bounds.z * bounds.z * WIDER;
    let low = lo - SLACK - bounds.xy;
    let high = hi + SLACK - bounds.xy;
    let w = setup.whitening;
    let tilt = vec2(setup.tilt.x * w.x, setup.tilt.x * w.y + setup.tilt.y * w.z) * view.perspective;
    let open = 1.0 - squared * setup.spread * view.perspective;
    let xx = open * w.x * w.x - squared * tilt.x * tilt.x;
    let xy = open * w.x * w.y - squared * tilt.x * tilt.y;
    let yy = open * (w.y * w.y + w.z * w.z) - squared * tilt.y * tilt.y;
    // Written so that a NaN touches.
    if !(open > 0.0 && xx > 0.0 && yy > 0.0) || is_beside(bounds) {
        return true;
    }
    let near = clamp(vec2(0.0), low, high);
    let along_x = clamp((squared * tilt.x - xy * near.y) / xx, low.x, high.x);
    let along_y = clamp((squared * tilt.y - xy * near.x) / yy, low.y, high.y);
    let x = vec2(along_x, near.x);
    let y = vec2(near.y, along_y);
    let u = w.x * x + w.y * y;
    let v = w.z * y;
    let ahead = 1.0 + tilt.x * x + tilt.y * y;
    return any(open * (u * u + v * v) <= squared * ahead * ahead);
}

// `look`: of the Gaussian's caster.
fn gaussian_hit(
    view: GpuView,
    footprint: Footprint,
    setup: GaussianSetup,
    look: u32,
    texel: vec2<f32>,
    opaque_depth: f32,
) -> GaussianHit {
    let met = approach(view, footprint, setup, texel);
    let color = unpack_color(setup.color, materials[look & 0xffffu].transfer);
    let thin = unpack2x16float(setup.color.y).y / OPACITY_SCALE;
    // Written so that a NaN is a miss.
    if !(met.squared <= footprint.bounds.z * footprint.bounds.z) {
        return GaussianHit(color, thin, 0.0, -1.0, -1.0);
    }
    let amplitude = gaussian_amplitude(footprint) * exp(-0.5 * met.squared);
    if !HAS_MEDIA || (look & MEDIUM_BIT) == 0u {
        return GaussianHit(color, thin, min(amplitude, 1.0), met.depth, met.depth);
    }
    let slope = (texel - view.size * 0.5) / view.scale * view.perspective;
    let metres = (view.far - view.near) * sqrt(1.0 + dot(slope, slope));
    let whole = amplitude * met.deviation * metres;
    let start = -met.depth / met.deviation;
    let end = (opaque_depth - met.depth) / met.deviation;
    let tau = whole * max(0.5 * (error_function(end) - error_function(start)), 0.0);
    let opacity = min(thin * tau_absorbed(vec3(tau)).x, 1.0);
    let ramp = medium_ramp(whole);
    // The ray may end in front of the stretch where the medium absorbs most.
    let first = max(min(ramp.x, end - AT_THE_END), start);
    let from_depth = max(met.depth + first * met.deviation, 0.0);
    let to_depth = max(met.depth + min(ramp.y, end) * met.deviation, from_depth);
    let misses = (end < -FARTHEST_TAIL) | (start > FARTHEST_TAIL);
    return GaussianHit(color, thin, opacity, select(from_depth, -1.0, misses), to_depth);
}

// Start and end of the linear ramp nearest to the transmittance in a medium of optical depth `tau` [standard
// deviations from the closest approach]. A fit: at most 0.06 off up to a depth of 16, 0.073 up to 10,000.
fn medium_ramp(tau: f32) -> vec2<f32> {
    // The ends meet at an optical depth of 3e6.
    let z = max(1.0 / (1.0 + 0.1386294 * log2(1.0 + tau)), 0.3);
    let start = ((((-18.81927 * z + 63.40576) * z - 75.2293) * z + 32.8231) * z + 3.39187) * z - 7.176147;
    let end = ((((1.58683 * z - 110.8377) * z + 269.0229) * z - 240.3027) * z + 101.2818) * z - 19.28979;
    return vec2(start, end);
}

// erf(x / sqrt(2)) within 2e-7 (Abramowitz and Stegun 1964, 7.1.26).
fn error_function(x: f32) -> f32 {
    let z = abs(x) * 0.70710678;
    let t = 1.0 / (1.0 + 0.3275911 * z);
    let series = ((((1.0614054 * t - 1.453152) * t + 1.4214138) * t - 0.28449674) * t + 0.2548296) * t;
    return sign(x) * (1.0 - series * exp(-z * z));
}
