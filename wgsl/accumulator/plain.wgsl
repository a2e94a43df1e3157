// Accumulator: transmittance and nearest depth of four or eight texels in a column, for casters of one simple
// kind: soft discs or splats, of the `filter` transfer. CPU reference: src/reference/accumulate.rs.

import package::bind::sampled::opaques;
import package::features::{FAINT, HAS_OPAQUE};
import package::hit::disc::Profile4;
import package::records::footprint::Footprint;
import package::records::owner::NO_OWNER;
import package::records::view::GpuView;
import package::sums::faint::keep4;
import package::sums::sums::{BLACK, VISIBLE_PRESENCE};
import choice::column::{COLUMN_TEXELS, FOURS};
import choice::plain::{Plain, broadcast, column_profile, plain_touches, prepare, presence};

const ROWS: u32 = COLUMN_TEXELS; // texels that an invocation holds, in a column
const LAST: u32 = FOURS - 1u; // of its fours

var<private> corner: vec2<f32>; // first of the texels, in the view's map
// Centre of the first of the eight texels by which a column is rounded, and how far below it the first four are.
var<private> first: vec2<f32>;
var<private> below: f32;
var<private> red: array<vec4<f32>, FOURS>; // transmittance so far
var<private> green: array<vec4<f32>, FOURS>;
var<private> blue: array<vec4<f32>, FOURS>;
var<private> lost: array<array<vec4<f32>, 3>, FOURS>; // absorbed by faint casters, not yet multiplied into the above
var<private> nearest: array<vec4<i32>, FOURS>; // depths by their bits, which are ordered like them
var<private> opaque_depth: array<vec4<f32>, FOURS>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    below = f32(texel.y & 4u);
    first = corner + vec2(0.5, 0.5 - below);
    start_rows(view, texel, 0u);
    if FOURS > 1u {
        start_rows(view, texel, LAST);
    }
}

fn start_rows(view: GpuView, texel: vec2<u32>, i: u32) {
    red[i] = vec4(1.0);
    green[i] = vec4(1.0);
    blue[i] = vec4(1.0);
    lost[i] = array(vec4(0.0), vec4(0.0), vec4(0.0));
    nearest[i] = bitcast<vec4<i32>>(vec4(1.0));
    opaque_depth[i] = vec4(1.0);
    if HAS_OPAQUE {
        let at = view.origin + texel + vec2(0u, 4u * i);
        opaque_depth[i] = vec4(
            textureLoad(opaques, at, view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 1u), view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 2u), view.layer, 0).r,
            textureLoad(opaques, at + vec2(0u, 3u), view.layer, 0).r,
        );
    }
}

fn multiply(plain: Plain, profile: vec4<f32>, i: u32) {
    if FAINT {
        let r = keep4(red[i], lost[i][0], profile * plain.absorbed.r);
        let g = keep4(green[i], lost[i][1], profile * plain.absorbed.g);
        let b = keep4(blue[i], lost[i][2], profile * plain.absorbed.b);
        red[i] = r.passed;
        green[i] = g.passed;
        blue[i] = b.passed;
        lost[i] = array(r.lost, g.lost, b.lost);
        return;
    }
    red[i] *= 1.0 - profile * plain.absorbed.r;
    green[i] *= 1.0 - profile * plain.absorbed.g;
    blue[i] *= 1.0 - profile * plain.absorbed.b;
}

fn seek_nearest(plain: Plain, met: Profile4, i: u32) {
    let seen = presence(plain, met.profile) >= vec4(VISIBLE_PRESENCE);
    nearest[i] = min(nearest[i], bitcast<vec4<i32>>(select(vec4(1.0), met.depth, seen)));
}

// `seeks`: it may be nearer than the nearest depths.
fn visit_plain(view: GpuView, plain: Plain, seeks: bool) {
    let met = column_profile(view, plain, first, below, opaque_depth);
    multiply(plain, met[0].profile, 0u);
    if FOURS > 1u {
        multiply(plain, met[LAST].profile, LAST);
    }
    if seeks {
        seek_nearest(plain, met[0], 0u);
        if FOURS > 1u {
            seek_nearest(plain, met[LAST], LAST);
        }
    }
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    visit_plain(view, prepare(view, footprint), true);
}

// The caster of a lane.
alias LaneCaster = Footprint;

fn lane_caster_of(id: u32, footprint: Footprint) -> LaneCaster {
    return footprint;
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return plain_touches(view, caster, lo, hi);
}

// Payload that a lane broadcasts: its caster prepared for texels.
struct Payload {
    plain: Plain,
    seeks: bool, // some lane's may be nearer than some lane's nearest depths
}

// `front`: depth in front of which it is not.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return Payload(prepare(view, caster), subgroupAny(seeks(front)));
}

// Visits the caster of lane `lane`.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    visit_plain(view, broadcast(payload.plain, lane), payload.seeks);
}

// Whether a caster at or behind `front` may be the nearest.
fn seeks(front: f32) -> bool {
    let bits = vec4(bitcast<i32>(front));
    return any(nearest[0] > bits) || any(nearest[LAST] > bits);
}

fn passed_texel(i: u32) -> vec3<f32> {
    return vec3(red[i / 4u][i % 4u], green[i / 4u][i % 4u], blue[i / 4u][i % 4u]);
}

fn nearest_texel(i: u32) -> f32 {
    return bitcast<f32>(nearest[i / 4u][i % 4u]);
}

fn finish() {
    if FAINT {
        finish_rows(0u);
        if FOURS > 1u {
            finish_rows(LAST);
        }
    }
}

fn finish_rows(i: u32) {
    red[i] *= 1.0 - lost[i][0];
    green[i] *= 1.0 - lost[i][1];
    blue[i] *= 1.0 - lost[i][2];
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    return settled_rows(front, 0u) && settled_rows(front, LAST);
}

fn settled_rows(front: f32, i: u32) -> bool {
    let lit = (red[i] >= vec4(BLACK)) | (green[i] >= vec4(BLACK)) | (blue[i] >= vec4(BLACK));
    let seeks = nearest[i] > vec4(bitcast<i32>(front));
    return !any((lit | seeks) & (opaque_depth[i] > vec4(front)));
}

// Batches of plain casters have no owner tags.
fn owner_texel(i: u32) -> u32 {
    return NO_OWNER;
}
