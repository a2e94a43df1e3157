// Accumulator: transmittance and nearest depth of some texels in a column, for casters of one simple kind:
// soft discs or splats, of the `filter` transfer. CPU reference: crates/gobo-reference/src/accumulate.rs.

import package::bind::sampled::opaques;
import package::features::{FAINT, HAS_OPAQUE, unrolled};
import package::records::footprint::Footprint;
import package::records::texel::{Found, NO_OWNER};
import package::records::view::GpuView;
import package::sums::sums::{BLACK, VISIBLE_PRESENCE, keep};
import choice::column::COLUMN_TEXELS;
import choice::plain::{Plain, PlainHit, broadcast, plain_hit, plain_touches, prepare, presence};

const ROWS: u32 = COLUMN_TEXELS; // texels that an invocation holds, in a column

struct Texel {
    light: vec3<f32>, // transmittance so far
    lost: vec3<f32>,  // absorbed by faint casters, not yet multiplied into it
    nearest: f32,     // light depths: of the nearest visible hit, and of the opaque surface
    opaque: f32,
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> texels: array<Texel, ROWS>;
var<private> found: array<Found, ROWS>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i] = Texel(vec3(1.0), vec3(0.0), 1.0, 1.0);
        if HAS_OPAQUE {
            texels[i].opaque = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
        }
    }
}

// `seeks`: whether the caster may be nearer than the nearest depths.
fn visit_plain(view: GpuView, plain: Plain, seeks: bool) {
    let delta = corner + 0.5 - plain.center;
    var hits: array<PlainHit, ROWS>;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        hits[i] = plain_hit(view, plain, delta + vec2(0.0, f32(i)), texels[i].opaque);
        let absorbed = hits[i].profile * plain.absorbed;
        if FAINT {
            let kept = keep(texels[i].light, texels[i].lost, absorbed);
            texels[i].light = kept.passed;
            texels[i].lost = kept.lost;
        } else {
            texels[i].light *= 1.0 - absorbed;
        }
    }
    if seeks {
        for (var i = 0u; i < unrolled(ROWS); i += 1u) {
            let seen = presence(plain, hits[i]) >= VISIBLE_PRESENCE;
            texels[i].nearest = min(texels[i].nearest, select(1.0, hits[i].depth, seen));
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

// Whether the caster may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return plain_touches(view, caster, lo, hi);
}

// Payload that a lane broadcasts: its caster prepared for texels.
struct Payload {
    plain: Plain,
    seeks: bool, // some lane's caster may be nearer than some lane's nearest depths
}

// `front`: lower bound of the caster's depth.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return Payload(prepare(view, caster), subgroupAny(seeks(front)));
}

// Visits the caster of lane `lane`.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    visit_plain(view, broadcast(payload.plain, lane), payload.seeks);
}

// Whether a caster at or behind `front` may be the nearest.
fn seeks(front: f32) -> bool {
    var last = 0.0;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        last = max(last, texels[i].nearest);
    }
    return last > front;
}

fn finish() {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var light = texels[i].light;
        if FAINT {
            light *= 1.0 - texels[i].lost;
        }
        // Batches of plain casters have no owner tags.
        found[i] = Found(light, texels[i].nearest, NO_OWNER);
    }
}

fn is_open(texel: Texel, front: f32) -> bool {
    return (any(texel.light >= vec3(BLACK)) || texel.nearest > front) && texel.opaque > front;
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    var open = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        open = open || is_open(texels[i], front);
    }
    return !open;
}
