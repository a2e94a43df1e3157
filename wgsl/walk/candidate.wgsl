// A pair of a lane that a subgroup may visit: any caster. Lanes tell each other which it is, and all
// read its footprint.

import package::bind::loaded::footprints;
import package::hit::reach::touches_box;
import package::records::record::{FOOTPRINT_TEXELS, record_texel};
import package::records::view::GpuView;
import choice::state::visit;

struct Candidate {
    footprint: u32,
    place: vec4<u32>,
    look: vec4<u32>,
}

fn candidate(footprint: u32, place: vec4<u32>, look: vec4<u32>) -> Candidate {
    return Candidate(footprint, place, look);
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, own: Candidate, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return touches_box(view, own.place, own.look, lo, hi);
}

// What another lane holds.
fn visit_lane(view: GpuView, own: Candidate, lane: u32) {
    let visited = subgroupShuffle(own.footprint, lane);
    let at = visited * FOOTPRINT_TEXELS;
    visit(
        view,
        visited,
        textureLoad(footprints, record_texel(at)),
        textureLoad(footprints, record_texel(at + 1u)),
    );
}
