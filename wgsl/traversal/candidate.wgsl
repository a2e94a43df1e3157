// Any caster as a lane's candidate for a visit. A lane offers its id, and all load its footprint.

import package::hit::reach::touches_box;
import package::records::footprint::Footprint;
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import package::traversal::kinds::visited;
import package::traversal::subgroup_block::shared_index;
import choice::accumulator::visit;

struct Candidate {
    id: u32,
    footprint: Footprint,
}

alias Offer = u32;

fn candidate_of(id: u32, footprint: Footprint) -> Candidate {
    return Candidate(id, footprint);
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, candidate: Candidate, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return touches_box(view, candidate.footprint, lo, hi);
}

// What a lane offers of it to the others. `front`: depth in front of which it is not.
fn offer_of(view: GpuView, candidate: Candidate, front: f32) -> Offer {
    return candidate.id;
}

// Visits the candidate of lane `lane`. `is_triangle`: kind of the loop.
fn visit_lane(view: GpuView, offer: Offer, lane: u32, is_triangle: bool) {
    let id = shared_index(subgroupShuffle(offer, lane));
    visit(view, id, visited(load_footprint(id), is_triangle));
}
