// Accumulator: a column of texels of an invocation of wgsl/llvmpipe/curve_queue.wgsl.

import package::bind::sampled::opaques;
import package::curve::node::{DEPTHS, packed_node, quick_passed};
import package::features::{FAINT, HAS_OPAQUE, NODES, PERSPECTIVE, unrolled};
import package::hit::disc::{Disc, DiscHit, disc_hit};
import package::records::view::GpuView;
import package::sums::sums::{BLACK, VISIBLE_PRESENCE, keep};
import choice::column::COLUMN_TEXELS;
import choice::output::{is_blank, scattered, scattered_light, store_nodes};

const ROWS: u32 = COLUMN_TEXELS; // texels that an invocation holds, in a column

const TRACE: f32 = 0.0000152587890625; // presence below which hits have no node of their own: 2^-16

struct Texel {
    light: vec3<f32>, // behind the hits so far
    lost: vec3<f32>,  // with `FAINT`: absorbed, not yet multiplied into it
    sum: f32,         // of the light's channels
    nearest: f32,     // light depths: of the nearest visible hit, and of the opaque surface
    opaque: f32,
    count: f32,       // hits; faint ones count in part
    // Open node: light that it takes, and the first two moments of the light's depth from `anchor`.
    taken: f32,
    off: f32,
    square: f32,
    low: f32,         // light depths that the node spans, in perspective views
    high: f32,
    left: vec3<f32>,  // light behind the stored nodes
    before: vec2<u32>, // first and second node of a pair
    node: vec2<u32>,
    rest: vec2<u32>,  // node of the casters without pairs
    rest_light: vec3<f32>, // light that they pass
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> texels: array<Texel, ROWS>;
// Transmittance of all hits, and depth of the nearest visible one, per texel.
var<private> found: array<vec4<f32>, ROWS>;
// Origin of the open node's moments, and the light depths that the node spans.
var<private> anchor: f32;
var<private> low: f32;
var<private> high: f32;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i] = Texel();
        texels[i].nearest = 1.0;
        texels[i].opaque = 1.0;
        texels[i].left = vec3(1.0);
        texels[i].rest_light = vec3(1.0);
        texels[i].rest = unused_node();
        if HAS_OPAQUE {
            texels[i].opaque = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
        }
    }
    light_all();
}

// Called before a walk.
fn light_all() {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i].light = vec3(1.0);
        texels[i].lost = vec3(0.0);
        texels[i].sum = 3.0;
    }
}

fn light_of(i: u32) -> vec3<f32> {
    if FAINT {
        return texels[i].light * (1.0 - texels[i].lost);
    }
    return texels[i].light;
}

fn pass_light(i: u32, absorbed: vec3<f32>) {
    if FAINT {
        let kept = keep(texels[i].light, texels[i].lost, absorbed);
        texels[i].light = kept.passed;
        texels[i].lost = kept.lost;
    } else {
        texels[i].light *= 1.0 - absorbed;
    }
}

fn hit_of(view: GpuView, disc: Disc, i: u32) -> DiscHit {
    return disc_hit(view, disc, corner + vec2(0.5, f32(i) + 0.5) - disc.center, texels[i].opaque);
}

// `counts`: whether this is the first walk.
fn visit(view: GpuView, disc: Disc, counts: bool) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let hit = hit_of(view, disc, i);
        let absorbed = hit.profile * disc.absorbed;
        let presence = hit.profile * disc.slope;
        if counts {
            pass_light(i, absorbed);
            texels[i].count += min(presence * (1.0 / TRACE), 1.0);
            texels[i].nearest = min(texels[i].nearest, select(1.0, hit.depth, presence >= VISIBLE_PRESENCE));
        } else {
            pass_light(i, absorbed);
            let behind = dot(light_of(i), vec3(1.0));
            let taken = texels[i].sum - behind;
            let off = hit.depth - anchor;
            texels[i].sum = behind;
            texels[i].taken += taken;
            texels[i].off += taken * off;
            texels[i].square += taken * (off * off);
            if PERSPECTIVE {
                let is = presence > 0.0;
                texels[i].low = select(texels[i].low, min(texels[i].low, hit.depth), is);
                texels[i].high = select(texels[i].high, max(texels[i].high, hit.depth), is);
            }
        }
    }
}

// The first walk's visit, for a quarter of the rows and light alone.
fn sample(view: GpuView, disc: Disc) {
    pass_light(2u, hit_of(view, disc, 2u).profile * disc.absorbed);
    pass_light(5u, hit_of(view, disc, 5u).profile * disc.absorbed);
}

// Adds casters without pairs as a hit and a node behind all others. `last`: depth of the last caster with
// pairs.
fn add_scattered(last: f32) {
    for (var turn = 0u; turn < u32(scattered()); turn += 1u) {
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            let rest = scattered_light(corner, i);
            let is_hit = any(rest.light < vec3(1.0));
            let depth = max(select(texels[i].nearest, rest.depth, rest.depth < 1.0), last);
            let start = u32(clamp(round(depth * DEPTHS), 1.0, DEPTHS));
            texels[i].rest = select(unused_node(), packed_node(start, 0.0, rest.light), is_hit);
            texels[i].rest_light = rest.light;
            texels[i].count += select(0.0, 1.0, is_hit);
            texels[i].nearest = min(texels[i].nearest, rest.depth);
        }
    }
}

fn open_node(depth: f32) {
    anchor = depth;
    low = depth;
    high = depth;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i].taken = 0.0;
        texels[i].off = 0.0;
        texels[i].square = 0.0;
        texels[i].low = 2.0;
        texels[i].high = 0.0;
    }
}

// The open node of a texel, if it takes light.
fn node_of(i: u32) -> vec2<u32> {
    let texel = texels[i];
    let share = 1.0 / max(texel.taken, 1e-30);
    let off = texel.off * share;
    let spread = max(texel.square * share - off * off, 0.0);
    let begins = select(low, texel.low, PERSPECTIVE);
    let ends = select(high, max(texel.high, begins), PERSPECTIVE);
    let mean = clamp(anchor + off, begins, ends);
    let half = min(sqrt(3.0 * spread), min(mean - begins, ends - mean));
    let light = light_of(i);
    let passed = select(min(light / max(texel.left, vec3(1e-9)), vec3(1.0)), vec3(0.0), light < vec3(BLACK));
    let fixed = u32(clamp(round((mean - half) * DEPTHS), 1.0, DEPTHS));
    let node = packed_node(fixed, 2.0 * half * DEPTHS, passed);
    let is = (texel.taken > 0.0) & (texel.count >= f32(NODES + 1u));
    texels[i].left *= select(vec3(1.0), quick_passed(node), is);
    return select(unused_node(), node, is);
}

// Called after a walk over all light.
fn keep_found() {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        found[i] = vec4(texels[i].rest_light * light_of(i), texels[i].nearest);
    }
}

// Ends the open node of every texel.
fn end_nodes() {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let node = node_of(i);
        texels[i].before = texels[i].node;
        texels[i].node = node;
    }
}

// Stores the last two nodes. `is_last`: the node of the casters without pairs comes behind them.
fn store_pairs(view: GpuView, pair: u32, is_last: bool) {
    for (var turn = u32(is_blank()); turn < 1u; turn += 1u) {
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            let is_rest = is_last & (texels[i].rest.x >= 0x10000u);
            let rest = select(unused_node(), texels[i].rest, texels[i].count >= f32(NODES + 1u));
            store_nodes(view, corner, i, pair, vec4(texels[i].before, select(texels[i].node, rest, is_rest)));
        }
    }
}

// Number of nodes for discs.
fn node_count() -> u32 {
    return NODES - u32(scattered());
}

fn unused_node() -> vec2<u32> {
    return packed_node(0u, 0.0, vec3(1.0));
}
