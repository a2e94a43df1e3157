// Accumulator: curves of an invocation's texels by two walks, for hits that only pass light on. The first
// walk finds the light behind all hits, their number and extent, and the costs of joining neighbours. CPU
// reference: crates/gobo-reference/src/curve/two_walks.rs.

import package::bind::sampled::opaques;
import package::curve::bodies::{MIN_BEND, SHORTEST};
import package::curve::node::{DEPTHS, grows};
import package::curve::ray_nodes::{place_hit, single_ramp, write_node};
import package::features::{FAINT, HAS_OPAQUE, HAS_PUFFS, HAS_SOFTENING, NODES, unrolled};
import package::records::footprint::Footprint;
import package::records::view::GpuView;
import package::sums::sums::{BLACK, VISIBLE_PRESENCE, keep};
import choice::output::SPLITS;
import choice::rows::ROW_COUNT;
import choice::visit::{OFTEN_FEW, READS_OPAQUE, visit_caster};

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

const TRACE: f32 = 0.0000152587890625; // presence below which hits have no place of their own: 2^-16
const LEAST_GAP: f32 = 0.00390625; // of a pair: so strong hits close together still cost something
const COST_BINS: u32 = 32u; // of the pairs' costs, about half an octave each

struct Texel {
    light: vec3<f32>, // behind the hits so far
    lost: vec3<f32>,  // with `FAINT`: absorbed, not yet multiplied into `light`
    traces: f32,      // with `FAINT`: presence of the hits since the last place
    nearest: f32,     // light depths: of the nearest visible hit, and of the opaque surface
    opaque: f32,
    at: f32,          // largest depth of a place so far
    took: f32,        // light that the hit at the last place took, the sum of its channels
    count: u32,       // hits that have places
    first: f32,       // first and last light depth of these places
    last: f32,
    all: f32,         // light that these hits take
    low_bins: vec4<u32>, // pairs of neighbours by cost, 8 bits per bin: exact up to 255
    high_bins: vec4<u32>,
    bends: f32,       // of the bodies still to come
    // In the second walk:
    spare: u32,       // nodes to split bodies with
    bin: u32,         // pairs that cost less are joined, and `equal` pairs of this bin
    equal: u32,
    seen: u32,        // hits so far
    used: u32,        // nodes so far
    gone: f32,        // light lost so far
    open: bool,
    place: f32,       // on the ray: where the open node began, and where it ends
    cut: f32,
    before: vec3<f32>, // light in front of the open node, but for that lost to hits with nodes of their own
    low: f32,         // light depths that the open node spans
    high: f32,
    anchor: f32,      // start of its first hit
    taken: f32,       // light, and the first two moments of its depth from `anchor`
    sum: f32,
    square: f32,
    owed: vec3<f32>,  // light that rounding took from the nodes so far
    pending: vec2<u32>, // first node of a pair, not yet stored
}

// Effect of a caster on the light of a ray.
struct RayHit {
    absorbed: vec3<f32>,
    depth: f32,    // light depths: of the hit, and of the stretch where it takes light
    start: f32,
    end: f32,
    presence: f32, // weight of the hit in depths; 0 for none
}

// A hit with its place on the ray.
struct Placed {
    is: bool,
    light: vec3<f32>,  // in front of the hit, and behind
    behind: vec3<f32>,
    z: f32,            // largest depth of a place so far
    taken: f32,
    bin: u32,          // cost bin of joining the hit to the one before
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> texels: array<Texel, ROWS>;
// Transmittance of all hits, and depth of the nearest visible one, per texel.
var<private> found: array<vec4<f32>, ROWS>;
var<private> is_second: bool;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    is_second = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i] = Texel();
        texels[i].nearest = 1.0;
        texels[i].opaque = 1.0;
        texels[i].first = 1.0;
        texels[i].light = vec3(1.0);
        texels[i].owed = vec3(1.0);
        if HAS_OPAQUE || READS_OPAQUE {
            texels[i].opaque = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
        }
    }
}

// Begins the second walk.
fn begin_second() {
    is_second = true;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        if !is_finished(&texel) {
            if OFTEN_FEW {
                find_joined(&texel);
            }
            texel.last = texel.at;
            texel.light = vec3(1.0);
            texel.lost = vec3(0.0);
            texel.traces = 0.0;
            texel.at = 0.0;
            texel.took = 0.0;
            texel.used = 0u;
            texel.owed = vec3(1.0);
        }
        texels[i] = texel;
    }
}

fn light_of(t: ptr<function, Texel>) -> vec3<f32> {
    if FAINT {
        return (*t).light * (1.0 - (*t).lost);
    }
    return (*t).light;
}

fn is_dark(light: vec3<f32>) -> bool {
    return !grows() && all(light < vec3(BLACK));
}

// Cost bin of a pair.
fn bin_of(cost: f32) -> u32 {
    let half_octaves = bitcast<u32>(cost) >> 22u;
    return min(max(half_octaves, 254u - COST_BINS) - (254u - COST_BINS), COST_BINS - 1u);
}

fn bin_count(t: ptr<function, Texel>, bin: u32) -> u32 {
    let bins = select((*t).low_bins, (*t).high_bins, vec4(bin >= 16u));
    let low = select(bins.x, bins.y, (bin & 4u) != 0u);
    let high = select(bins.z, bins.w, (bin & 4u) != 0u);
    return (select(low, high, (bin & 8u) != 0u) >> (8u * (bin & 3u))) & 255u;
}

// Deviation of a body's light from a straight line: the difference of roots, where that is worth a node.
fn bend_of(hit: RayHit, placed: Placed) -> f32 {
    let roots = sqrt(max(placed.light, vec3(0.0))) - sqrt(max(placed.behind, vec3(0.0)));
    let bend = max(max(abs(roots.r), abs(roots.g)), abs(roots.b));
    let is_long = round(hit.end * DEPTHS) >= max(round(hit.start * DEPTHS), 1.0) + f32(SHORTEST);
    return select(0.0, bend, is_long && bend > MIN_BEND && placed.is);
}

// Finds which pairs to join: those that cost least, as many as there are more hits than nodes.
fn find_joined(t: ptr<function, Texel>) {
    (*t).spare = max(NODES, (*t).count + u32(HAS_SOFTENING)) - ((*t).count + u32(HAS_SOFTENING));
    (*t).bin = 0u;
    (*t).equal = max((*t).count, NODES) - NODES;
    for (var bin = 0u; bin + 1u < COST_BINS; bin += 1u) {
        let pairs = bin_count(t, bin);
        let all = (*t).bin == bin && pairs < (*t).equal;
        (*t).equal -= select(0u, pairs, all);
        (*t).bin += select(0u, 1u, all);
    }
}

// Adds a hit to the light. Behind black it has a place only if it comes late, where it can change something.
fn pass_hit(t: ptr<function, Texel>, hit: RayHit) -> Placed {
    let light = light_of(t);
    let acts = !is_dark(light) || hit.start < (*t).at;
    var placed = hit.presence >= TRACE;
    if FAINT {
        let kept = keep((*t).light, (*t).lost, hit.absorbed);
        (*t).light = kept.passed;
        (*t).lost = kept.lost;
        // Many hits below `TRACE` share a place.
        let traces = (*t).traces + hit.presence;
        placed = traces >= TRACE;
        (*t).traces = select(traces, 0.0, placed);
    } else {
        (*t).light *= 1.0 - hit.absorbed;
    }
    let behind = light_of(t);
    let taken = dot(abs(light - behind), vec3(1.0));
    let z = max(hit.start, (*t).at);
    let bin = bin_of(((*t).took + taken) * select(0.0, z - (*t).at + LEAST_GAP, z > (*t).at));
    return Placed(placed && acts, light, behind, z, taken, bin);
}

fn go_on(t: ptr<function, Texel>, placed: Placed) {
    (*t).at = select((*t).at, placed.z, placed.is);
    (*t).took = select(0.0, select((*t).took, placed.taken, placed.is), OFTEN_FEW);
}

// With `OFTEN_FEW`, counts pairs, and gives hits nodes while some are free: one walk suffices for few.
fn count_hit(view: GpuView, t: ptr<function, Texel>, i: u32, hit: RayHit) {
    let seen = hit.presence >= VISIBLE_PRESENCE;
    (*t).nearest = select((*t).nearest, min((*t).nearest, hit.depth), seen);
    let placed = pass_hit(t, hit);
    if OFTEN_FEW {
        let pair = select(0u, 1u << (8u * (placed.bin & 3u)), placed.is && (*t).count > 0u);
        (*t).low_bins += select(vec4(0u), vec4(pair), vec4(placed.bin >> 2u) == vec4(0u, 1u, 2u, 3u));
        (*t).high_bins += select(vec4(0u), vec4(pair), vec4(placed.bin >> 2u) == vec4(4u, 5u, 6u, 7u));
    }
    (*t).count += select(0u, 1u, placed.is);
    (*t).first = select((*t).first, min((*t).first, hit.start), placed.is);
    (*t).all += select(0.0, placed.taken, placed.is);
    if splits() {
        (*t).bends += bend_of(hit, placed);
    } else if OFTEN_FEW {
        write_node(view, t, i, single_ramp(t, hit, placed), placed.is && (*t).used < NODES);
    }
    go_on(t, placed);
}

// Whether all nodes wait for the second walk, which splits bodies among the free ones.
fn splits() -> bool {
    return HAS_PUFFS && SPLITS;
}

// Whether the first walk has made all nodes.
fn is_finished(t: ptr<function, Texel>) -> bool {
    return OFTEN_FEW && !splits() && is_second && (*t).count <= NODES;
}

// Visits texel `i` in this walk.
fn visit_hit(view: GpuView, t: ptr<function, Texel>, i: u32, hit: RayHit) {
    if is_second {
        place_hit(view, t, i, hit);
    } else {
        count_hit(view, t, i, hit);
    }
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    visit_caster(view, footprint);
}

// Whether nothing at or behind `front` can change these texels in this walk.
fn settled(front: f32) -> bool {
    var open = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        let changes = !is_dark(light_of(&texel)) || front < texel.at;
        let seeks = !is_second && texel.nearest > front;
        open = open || ((changes || seeks) && texel.opaque > front && !is_finished(&texel));
    }
    return !open;
}
