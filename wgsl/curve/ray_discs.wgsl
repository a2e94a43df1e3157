// Visits an invocation's texels with soft discs of the `filter` transfer, which the lanes of a subgroup
// prepare for each other.

import package::curve::ray::{ROWS, RayHit, corner, texels, visit_hit};
import package::features::unrolled;
import package::hit::disc::{Disc, broadcast_disc, disc_hit, disc_touches, prepare_disc};
import package::records::footprint::Footprint;
import package::records::view::GpuView;

const READS_OPAQUE: bool = false; // only if there are opaque casters
const OFTEN_FEW: bool = false; // discs come by the hundred; the code for few hits takes registers

alias LaneCaster = Footprint;
alias Payload = Disc;

fn visit_disc(view: GpuView, disc: Disc) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        let delta = corner + vec2(0.5, f32(i) + 0.5) - disc.center;
        let hit = disc_hit(view, disc, delta, texel.opaque);
        let presence = hit.profile * disc.slope;
        let absorbed = hit.profile * disc.absorbed;
        visit_hit(view, &texel, i, RayHit(absorbed, hit.depth, hit.depth, hit.depth, presence));
        texels[i] = texel;
    }
}

fn visit_caster(view: GpuView, footprint: Footprint) {
    visit_disc(view, prepare_disc(view, footprint));
}

fn lane_caster_of(id: u32, footprint: Footprint) -> LaneCaster {
    return footprint;
}

// Whether the disc may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return disc_touches(view, caster.bounds, lo, hi);
}

fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return prepare_disc(view, caster);
}

// Visits the disc of lane `lane`.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    visit_disc(view, broadcast_disc(payload, lane));
}
