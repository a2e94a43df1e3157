// A caster of a lane, of any kind: the lane broadcasts its id, and all load its footprint, and a Gaussian's
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

struct LaneCaster {
    id: u32,
    footprint: Footprint,
}

struct Payload {
    id: u32,
    plane: Facing,
    look: u32,
}

fn lane_caster_of(id: u32, footprint: Footprint) -> LaneCaster {
    return LaneCaster(id, footprint);
}

// Whether it may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return touches_box(view, caster.footprint, lo, hi);
}

// Payload that the lane broadcasts; `front` bounds its depth from below.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    var payload: Payload;
    payload.id = caster.id;
    payload.look = look_of(caster.footprint);
    if SET_UP_ONCE {
        payload.plane = plane_of(view, caster.footprint, payload.look);
    }
    return payload;
}

fn broadcast_plane(sent: Facing, lane: u32) -> Facing {
    var plane: Facing;
    if HAS_FACING && SET_UP_ONCE {
        plane = Facing(
            subgroupShuffle(sent.reference, lane),
            subgroupShuffle(sent.frame_x, lane),
            subgroupShuffle(sent.frame_y, lane),
            subgroupShuffle(sent.offset, lane),
            subgroupShuffle(sent.tilt, lane),
            subgroupShuffle(sent.start, lane),
            subgroupShuffle(sent.distance, lane),
        );
    }
    return plane;
}

// Visits the caster of lane `lane`. `is_triangle`: kind of the loop.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    let id = shared_index(subgroupShuffle(payload.id, lane));
    let footprint = visited(load_footprint(id), is_triangle);
    let look = shared_index(subgroupShuffle(payload.look, lane));
    var plane = broadcast_plane(payload.plane, lane);
    if !SET_UP_ONCE {
        plane = plane_of(view, footprint, look);
    }
    let faced = Faced(plane, gaussian_of(footprint), capsule_in(view, footprint), look);
    visit_faced(view, id, footprint, faced);
}
