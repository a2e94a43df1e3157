// Accumulator: the curve of an invocation's texel by two walks, of soft discs of the `filter` transfer. The first walk finds
// the light behind all hits, how many there are, and where. CPU reference: src/reference/curve/two_walks.rs.

import package::bind::sampled::opaques;
import package::features::{FAINT, HAS_OPAQUE};
import package::records::view::GpuView;
import package::sums::faint::keep;
import package::sums::sums::{BLACK, VISIBLE_PRESENCE};

const ROWS: u32 = 1u; // texels that an invocation holds

const TRACE: f32 = 0.0000152587890625; // presence below which hits have no place of their own: 2^-16

struct Texel {
    light: vec3<f32>, // behind the hits so far
    lost: vec3<f32>,  // with `FAINT`: absorbed, not yet multiplied into it
    traces: f32,      // with `FAINT`: presence of the hits since one had a place
    nearest: f32,     // light depths: of the nearest visible hit, and of the opaque surface
    opaque: f32,
    count: u32,       // hits that have places
    first: f32,       // light depths between which they are
    last: f32,
    all: f32,         // light that is lost, the sum of the channels
    // In the second walk:
    seen: u32,        // hits so far
    used: u32,        // nodes so far
    gone: f32,        // light lost so far
    at: f32,          // the largest depth so far
    cut: f32,         // place at which the open node ends
    place: f32,       // at which it began
    open: bool,
    open_light: vec3<f32>, // in front of it, behind what is not its own
    low: f32,         // light depths that it spans
    high: f32,
    anchor: f32,      // its first
    taken: f32,       // light, and the first two moments of its depth from `anchor`
    sum: f32,
    square: f32,
    owed: vec3<f32>,  // what rounding has taken of the nodes so far
    before: vec2<u32>, // the first node of a pair
}

var<private> corner: vec2<f32>; // the texel, in the view's map
var<private> ray: Texel;
var<private> is_second: bool;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    ray = Texel();
    ray.nearest = 1.0;
    ray.opaque = 1.0;
    if HAS_OPAQUE {
        ray.opaque = textureLoad(opaques, view.origin + texel, view.layer, 0).r;
    }
}

// Begins a walk: the first, and then the second.
fn begin_walk(second: bool) {
    is_second = second;
    ray.all = 3.0 - dot(light_of(), vec3(1.0));
    ray.light = vec3(1.0);
    ray.lost = vec3(0.0);
    ray.traces = 0.0;
    ray.first = select(1.0, ray.first, second);
    ray.owed = vec3(1.0);
}

fn light_of() -> vec3<f32> {
    if FAINT {
        return ray.light * (1.0 - ray.lost);
    }
    return ray.light;
}

fn is_dark(light: vec3<f32>) -> bool {
    return all(light < vec3(BLACK));
}

fn last_before() -> f32 {
    return select(ray.last, ray.at, is_second);
}

// Adds a hit to the light. Returns whether it has a place: behind black only what comes late can change anything.
fn pass_hit(absorbed: vec3<f32>, depth: f32, presence: f32) -> bool {
    let acts = !is_dark(light_of()) || depth < last_before();
    var placed = presence >= TRACE;
    if FAINT {
        let kept = keep(ray.light, ray.lost, absorbed);
        ray.light = kept.passed;
        ray.lost = kept.lost;
        // Many hits below `TRACE` have a depth together.
        ray.traces += presence;
        placed = ray.traces >= TRACE;
        ray.traces = select(ray.traces, 0.0, placed);
    } else {
        ray.light *= 1.0 - absorbed;
    }
    return placed && acts;
}

fn count_hit(absorbed: vec3<f32>, depth: f32, presence: f32) {
    if presence >= VISIBLE_PRESENCE {
        ray.nearest = min(ray.nearest, depth);
    }
    if pass_hit(absorbed, depth, presence) {
        ray.count += 1u;
        ray.first = min(ray.first, depth);
        ray.last = max(ray.last, depth);
    }
}

// Whether nothing at or behind `front` can change these texels in this walk.
fn settled(front: f32) -> bool {
    let changes = !is_dark(light_of()) || front < last_before();
    let seeks = !is_second && ray.nearest > front;
    return !((changes || seeks) && ray.opaque > front);
}

// Transmittance of all hits, and depth of the nearest visible one.
fn found_light(i: u32) -> vec3<f32> {
    return light_of();
}

fn found_depth(i: u32) -> f32 {
    return ray.nearest;
}
