// Walks a tile's pairs front to back, a subgroup at a time: every lane takes the caster of one footprint and
// tests it against the subgroup's block of texels; all lanes visit those that touch it. The accumulator's
// `settled` ends the walk.

import package::features::HAS_PARTICLES;
import package::records::footprint::{footprint_key, key_depth, load_footprint};
import package::records::view::GpuView;
import package::traversal::lane::{
    ALL_LANES, Block, block_high, block_low, first_lane, has_lane, has_lanes, subgroup_block, without_first,
};
import package::traversal::lane_caster::kinds_apart;
import choice::accumulator::settled;
import choice::lane_caster::{Payload, lane_caster_of, payload_of, touches, visit_lane};
import choice::records::pair_record;

// Pairs that wait for their visit, one per lane.
struct Stretch {
    payload: Payload,
    lanes: vec2<u32>,     // whose caster touches the block
    triangles: vec2<u32>, // whose caster is a triangle
    front: f32,           // no later pair is nearer
}

fn fetch(view: GpuView, base: u32, end: u32, block: Block, front: f32) -> Stretch {
    let pair = base + block.lane;
    // An empty tile has no pair, but the load needs a valid index.
    let id = pair_record(min(pair, max(end, 1u) - 1u)).y;
    let footprint = load_footprint(id);
    let caster = lane_caster_of(id, footprint);
    var triangles = vec2(0u);
    if kinds_apart() {
        triangles = subgroupBallot(footprint.is_triangle).xy;
    }
    let lanes = subgroupBallot(pair < end && touches(view, caster, block_low(block), block_high(block))).xy;
    return Stretch(
        payload_of(view, caster, front),
        lanes,
        triangles,
        key_depth(subgroupShuffle(footprint_key(footprint), block.size - 1u)),
    );
}

// Whether a caster of the kind is the next to visit.
fn is_next(stretch: Stretch, is_triangle: bool) -> bool {
    if kinds_apart() {
        let found = has_lane(stretch.triangles, first_lane(stretch.lanes));
        return has_lanes(stretch.lanes) && found == is_triangle;
    }
    return has_lanes(stretch.lanes);
}

// Visits casters, up to the first of the other kind where kinds are apart. Returns the remaining lanes.
fn visit_run(view: GpuView, first: Stretch, is_triangle: bool) -> vec2<u32> {
    var stretch = first;
    loop {
        if is_next(stretch, is_triangle) {
            visit_lane(view, stretch.payload, first_lane(stretch.lanes), is_triangle);
            stretch.lanes = without_first(stretch.lanes);
        }
        if !is_next(stretch, is_triangle) {
            break;
        }
    }
    return stretch.lanes;
}

fn visit_pairs(view: GpuView, first: u32, end: u32) {
    let block = subgroup_block();
    var base = first;
    var front = 0.0; // no pair from `base` on is nearer
    var unvisited = ALL_LANES;
    var open = true;
    loop {
        var stretch: Stretch;
        // Where kinds are apart, up to the next triangle.
        loop {
            stretch = fetch(view, base, end, block, front);
            stretch.lanes &= unvisited;
            stretch.lanes = visit_run(view, stretch, !HAS_PARTICLES);
            if !has_lanes(stretch.lanes) {
                base += block.size;
                front = stretch.front;
                unvisited = ALL_LANES;
                open = base < end && !subgroupAll(settled(front));
            }
            if has_lanes(stretch.lanes) | !open {
                break;
            }
        }
        if kinds_apart() {
            unvisited = visit_run(view, stretch, true);
        }
        if !open {
            break;
        }
    }
}

fn walk(view: GpuView, first: u32, end: u32) {
    visit_pairs(view, first, end);
}
