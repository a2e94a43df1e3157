// Any caster as a lane's candidate for a visit. Lanes broadcast its id, and all load its footprint.

import package::hit::reach::touches_box;
import package::records::footprint::Footprint;
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import choice::state::visit;

struct Candidate {
    id: u32,
    footprint: Footprint,
}

fn candidate(id: u32, footprint: Footprint) -> Candidate {
    return Candidate(id, footprint);
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, own: Candidate, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return touches_box(view, own.footprint, lo, hi);
}

// Visits another lane's candidate.
fn visit_lane(view: GpuView, own: Candidate, lane: u32) {
    let visited = subgroupShuffle(own.id, lane);
    visit(view, visited, load_footprint(visited));
}
