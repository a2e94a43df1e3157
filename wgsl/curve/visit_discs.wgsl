// Visits the four texels with a soft disc of the `filter` transfer; hits stay open until the end of their
// slab. CPU reference: src/reference/curve/tile.rs.

import package::curve::gather::{TRACE, corner, hit_count, join, must_flush, opaque_depth, see};
import package::curve::light4::{Light4, minus, white4};
import package::features::{HAS_OPAQUE, PERSPECTIVE};
import package::hit::disc::{
    Disc, Profile4, broadcast_disc, column_rest, disc_profile, disc_touches, prepare_disc, rest_profile,
};
import package::records::footprint::Footprint;
import package::records::view::GpuView;

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

fn waiting_steps() -> u32 {
    return 0u;
}

fn join_waiting() {}

fn texels_profile(view: GpuView, disc: Disc) -> Profile4 {
    let dx = corner.x + 0.5 - disc.center.x;
    let dy = corner.y + 0.5 - disc.center.y;
    if PERSPECTIVE {
        return disc_profile(view, disc, dx, dy + vec4(0.0, 1.0, 2.0, 3.0), opaque_depth);
    }
    return rest_profile(disc, column_rest(disc, dx, dy), opaque_depth);
}

fn disc_absorbed(disc: Disc, profile: vec4<f32>) -> Light4 {
    return Light4(profile * disc.absorbed.r, profile * disc.absorbed.g, profile * disc.absorbed.b);
}

// Counts a hit for `few`, and updates the nearest depth.
fn count_disc(view: GpuView, disc: Disc) {
    let met = texels_profile(view, disc);
    let opacity = met.profile * disc.slope;
    hit_count += select(vec4(0u), vec4(1u), opacity >= vec4(TRACE));
    see(met.depth, opacity);
}

// Returns where the hit has a depth of its own.
fn visit_disc(view: GpuView, disc: Disc) -> vec4<bool> {
    let met = texels_profile(view, disc);
    let absorbed = disc_absorbed(disc, met.profile);
    return join(minus(white4(), absorbed), absorbed, met.depth, met.profile * disc.slope);
}

fn count_hits(view: GpuView, footprint: Footprint) {
    count_disc(view, prepare_disc(view, footprint));
}

// Returns true if the hits must be inserted at once.
fn visit(view: GpuView, footprint: Footprint) -> bool {
    return must_flush(visit_disc(view, prepare_disc(view, footprint)));
}

// A disc as a lane's candidate for a visit. A lane offers it prepared for texels.
alias Candidate = Footprint;

fn candidate_of(id: u32, footprint: Footprint) -> Candidate {
    return footprint;
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, candidate: Candidate, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return disc_touches(view, candidate.place, lo, hi);
}

alias Offer = Disc;

// What a lane offers of it to the others.
fn offer_of(view: GpuView, candidate: Candidate, front: f32) -> Offer {
    return prepare_disc(view, candidate);
}

// Counts the hits of the candidate of lane `lane`.
fn count_lane(view: GpuView, offer: Offer, lane: u32) {
    count_disc(view, broadcast_disc(offer, lane));
}

// Visits the candidate of lane `lane`. Single hits are appended at once, all others wait for the end of
// their slab, so none must be inserted.
fn visit_lane(view: GpuView, offer: Offer, lane: u32, is_triangle: bool) -> bool {
    let placed = visit_disc(view, broadcast_disc(offer, lane));
    return false;
}
