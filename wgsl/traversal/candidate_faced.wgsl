// Any caster as a lane's candidate for a visit. A lane sets a particle up once, for all that visit it, and
// offers it with its id; all load its footprint.

import package::features::{HAS_CAPSULES, HAS_FACING, HAS_GAUSSIANS};
import package::hit::capsule::{CapsuleSetup, capsule_setup};
import package::hit::caster_hit::{Faced, faced_of};
import package::hit::hit::Facing;
import package::hit::reach::touches_box;
import package::records::capsule::is_capsule;
import package::records::caster::caster_look;
import package::records::footprint::{Footprint, caster_of};
import package::records::footprint_loaded::load_footprint;
import package::records::gaussian::GaussianSetup;
import package::records::view::GpuView;
import package::traversal::kinds::visited;
import choice::accumulator::visit_faced;

struct Candidate {
    id: u32,
    footprint: Footprint,
}

struct Offer {
    id: u32,
    faced: Faced,
}

fn candidate_of(id: u32, footprint: Footprint) -> Candidate {
    return Candidate(id, footprint);
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, candidate: Candidate, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return touches_box(view, candidate.footprint, lo, hi);
}

// What a lane offers of it to the others. `front`: depth in front of which it is not.
fn offer_of(view: GpuView, candidate: Candidate, front: f32) -> Offer {
    return Offer(candidate.id, faced_of(view, candidate.footprint));
}

fn broadcast_faced(faced: Faced, lane: u32) -> Faced {
    let own = faced.plane;
    let plane = Facing(
        subgroupShuffle(own.reference, lane),
        subgroupShuffle(own.frame_x, lane),
        subgroupShuffle(own.frame_y, lane),
        subgroupShuffle(own.offset, lane),
        subgroupShuffle(own.tilt, lane),
        subgroupShuffle(own.start, lane),
        subgroupShuffle(own.distance, lane),
    );
    var setup: GaussianSetup;
    if HAS_GAUSSIANS {
        setup = GaussianSetup(
            subgroupShuffle(faced.gaussian.whitening, lane),
            subgroupShuffle(faced.gaussian.spread, lane),
            subgroupShuffle(faced.gaussian.tilt, lane),
            subgroupShuffle(faced.gaussian.color, lane),
        );
    }
    var capsule: CapsuleSetup; // set up where it is visited
    return Faced(plane, setup, capsule, subgroupShuffle(faced.look, lane));
}

// Visits the candidate of lane `lane`. `is_triangle`: kind of the loop.
fn visit_lane(view: GpuView, offer: Offer, lane: u32, is_triangle: bool) {
    let id = subgroupShuffle(offer.id, lane);
    let footprint = visited(load_footprint(id), is_triangle);
    var faced = broadcast_faced(offer.faced, lane);
    if HAS_CAPSULES && (!(HAS_FACING || HAS_GAUSSIANS) || is_capsule(footprint)) {
        faced.capsule = capsule_setup(view, caster_look(caster_of(footprint)));
    }
    visit_faced(view, id, footprint, faced);
}
