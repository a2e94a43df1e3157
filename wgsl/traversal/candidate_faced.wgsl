// Any caster as a lane's candidate for a visit. A lane offers its id, and all load its footprint, and a Gaussian's
// setup. On software adapters a lane sets a disc or quad up once, for all that visit it; on GPUs what it would keep
// takes more registers than there are.

import package::features::{HAS_FACING, SET_UP_ONCE};
import package::hit::caster_hit::{Faced, capsule_in, gaussian_of, look_of, plane_of};
import package::hit::hit::Facing;
import package::hit::reach::touches_box;
import package::records::footprint::Footprint;
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import package::traversal::kinds::visited;
import package::traversal::subgroup_block::shared_index;
import choice::accumulator::visit_faced;

struct Candidate {
    id: u32,
    footprint: Footprint,
}

struct Offer {
    id: u32,
    plane: Facing,
    look: u32,
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
    var offer: Offer;
    offer.id = candidate.id;
    offer.look = look_of(candidate.footprint);
    if SET_UP_ONCE {
        offer.plane = plane_of(view, candidate.footprint, offer.look);
    }
    return offer;
}

fn broadcast_plane(own: Facing, lane: u32) -> Facing {
    var plane: Facing;
    if HAS_FACING && SET_UP_ONCE {
        plane = Facing(
            subgroupShuffle(own.reference, lane),
            subgroupShuffle(own.frame_x, lane),
            subgroupShuffle(own.frame_y, lane),
            subgroupShuffle(own.offset, lane),
            subgroupShuffle(own.tilt, lane),
            subgroupShuffle(own.start, lane),
            subgroupShuffle(own.distance, lane),
        );
    }
    return plane;
}

// Visits the candidate of lane `lane`. `is_triangle`: kind of the loop.
fn visit_lane(view: GpuView, offer: Offer, lane: u32, is_triangle: bool) {
    let id = shared_index(subgroupShuffle(offer.id, lane));
    let footprint = visited(load_footprint(id), is_triangle);
    let look = shared_index(subgroupShuffle(offer.look, lane));
    var plane = broadcast_plane(offer.plane, lane);
    if !SET_UP_ONCE {
        plane = plane_of(view, footprint, look);
    }
    let faced = Faced(plane, gaussian_of(footprint), capsule_in(view, footprint), look);
    visit_faced(view, id, footprint, faced);
}
