// Visits an invocation's texels with a soft disc of the `filter` transfer; hits stay open until the end of
// their slab. CPU reference: src/reference/curve/tile.rs.

import package::curve::gather::{TRACE, corner, hit_count, join, must_flush, opaque_depth, see};
import package::curve::lights::{Lights, minus, white};
import package::features::{HAS_OPAQUE, PERSPECTIVE, unrolled};
import package::hit::disc::{Disc, broadcast_disc, disc_hit, disc_touches, prepare_disc};
import package::records::footprint::Footprint;
import package::records::view::GpuView;
import choice::rows::{ROW_COUNT, RowBits, RowIs, Rows, row, with_row};

// A disc of an orthographic view has one depth, so hits come in order.
fn ordered() -> bool {
    return !PERSPECTIVE;
}

fn blocked() -> bool {
    return HAS_OPAQUE;
}

fn slabbed() -> bool {
    return true;
}

fn is_whole() -> bool {
    return true;
}

fn waiting_steps() -> u32 {
    return 0u;
}

fn join_waiting() {}

fn join_delayed() {}

// A disc's profile and its light depth at the texels.
struct DiscRows {
    profile: Rows,
    depth: Rows,
}

fn disc_rows(view: GpuView, disc: Disc) -> DiscRows {
    var met = DiscRows(Rows(0.0), Rows(0.0));
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let delta = corner + vec2(0.5, f32(i) + 0.5) - disc.center;
        let hit = disc_hit(view, disc, delta, row(opaque_depth, i));
        met.profile = with_row(met.profile, i, hit.profile);
        met.depth = with_row(met.depth, i, hit.depth);
    }
    return met;
}

// Counts a hit for `few`, and updates the nearest depth.
fn count_disc(view: GpuView, disc: Disc) {
    let met = disc_rows(view, disc);
    let opacity = met.profile * disc.slope;
    hit_count += select(RowBits(0u), RowBits(1u), opacity >= Rows(TRACE));
    see(met.depth, opacity);
}

// Returns where the hit has a depth of its own.
fn visit_disc(view: GpuView, disc: Disc) -> RowIs {
    let met = disc_rows(view, disc);
    let absorbed = Lights(
        met.profile * disc.absorbed.r,
        met.profile * disc.absorbed.g,
        met.profile * disc.absorbed.b,
    );
    return join(minus(white(), absorbed), absorbed, met.depth, met.profile * disc.slope);
}

fn count_hits(view: GpuView, footprint: Footprint) {
    count_disc(view, prepare_disc(view, footprint));
}

// Returns true if the hits must be inserted at once.
fn visit(view: GpuView, footprint: Footprint) -> bool {
    return must_flush(visit_disc(view, prepare_disc(view, footprint)));
}

// The disc of a lane, whose payload is prepared for texels.
alias LaneCaster = Footprint;

fn lane_caster_of(id: u32, footprint: Footprint) -> LaneCaster {
    return footprint;
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return disc_touches(view, caster.bounds, lo, hi);
}

alias Payload = Disc;

// Payload that the lane broadcasts.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return prepare_disc(view, caster);
}

// Counts the hits of the caster of lane `lane`.
fn count_lane(view: GpuView, payload: Payload, lane: u32) {
    count_disc(view, broadcast_disc(payload, lane));
}

// Visits the caster of lane `lane`. Returns true if some lane's hits must be inserted at once.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) -> bool {
    return subgroupAny(must_flush(visit_disc(view, broadcast_disc(payload, lane))));
}
