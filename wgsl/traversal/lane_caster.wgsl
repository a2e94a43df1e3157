// A caster of a lane, of any kind: the lane broadcasts its id, and all load its footprint.

import package::hit::reach::touches_box;
import package::records::footprint::Footprint;
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import package::traversal::kinds::visited;
import package::traversal::subgroup_block::shared_index;
import choice::accumulator::visit;

struct LaneCaster {
    id: u32,
    footprint: Footprint,
}

alias Payload = u32;

fn lane_caster_of(id: u32, footprint: Footprint) -> LaneCaster {
    return LaneCaster(id, footprint);
}

// Whether the caster may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return touches_box(view, caster.footprint, lo, hi);
}

// Payload that the lane broadcasts; `front`: lower bound of the caster's depth.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return caster.id;
}

// Visits the caster of lane `lane`. `is_triangle`: kind of the loop.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    let id = shared_index(subgroupShuffle(payload, lane));
    visit(view, id, visited(load_footprint(id), is_triangle));
}
