// Walks a tile's pairs front to back, a slab at a time: every lane of a subgroup takes the caster of one
// footprint and tests it against the subgroup's block of texels; all lanes visit those that touch it. CPU
// reference: crates/gobo-reference/src/curve/tile.rs, `walk`.
//
// Drivers of software adapters take both sides of branches, but they leave loops, though only at their end:
// so insertion into the curves is outside the loop that visits, rare work has loops of its own, and loops
// test at their end whether to go on.

import package::curve::gather::{flush, merge, settled};
import package::curve::list::must_merge;
import package::curve::slab::{
    Slab, find_steps, first_slab, has_casters, is_within, next_slab, open_behind, steps_behind,
};
import package::curve::visit_hits::{is_whole, visit_lane};
import package::features::{HAS_PARTICLES, HAS_VOLUMES};
import package::records::footprint::{footprint_key, key_depth, load_footprint};
import package::records::view::GpuView;
import package::traversal::lane::{
    ALL_LANES, Block, block_high, block_low, first_lane, has_lane, has_lanes, subgroup_block, without_first,
};
import package::traversal::lane_caster::kinds_apart;
import choice::lane_caster::{Payload, lane_caster_of, payload_of, touches};
import choice::records::pair_record;

var<private> base: u32; // next pair
var<private> slab: Slab;

// A run of pairs, one per lane, up to the end of the slab.
struct Stretch {
    payload: Payload,
    ballot: vec2<u32>,    // lanes whose caster touches the block
    triangles: vec2<u32>, // lanes whose caster is a triangle
    count: u32,           // pairs within the slab
    key: u32,             // key of the lane's pair
}

fn fetch(view: GpuView, end: u32, block: Block) -> Stretch {
    let index = base + block.lane;
    // An empty tile has no pair, but the load needs a valid index.
    let id = pair_record(min(index, max(end, 1u) - 1u)).y;
    let footprint = load_footprint(id);
    let key = footprint_key(footprint);
    let caster = lane_caster_of(id, footprint);
    let within = index < end && is_within(slab, key);
    let in_slab = subgroupBallot(within);
    let ballot = subgroupBallot(within && touches(view, caster, block_low(block), block_high(block)));
    let count = countOneBits(in_slab.x) + countOneBits(in_slab.y);
    var triangles = vec2(0u);
    if kinds_apart() {
        triangles = subgroupBallot(footprint.is_triangle).xy;
    }
    // Made before the test, a payload would share terms with the test, which changes the rounding of some
    // drivers.
    return Stretch(payload_of(view, caster, key_depth(slab.key)), ballot.xy, triangles, count, key);
}

// Lanes of a stretch that wait for their visit.
struct Run {
    lanes: vec2<u32>,
    last: u32,    // lane visited last
    forced: bool, // some hit must be inserted before the next visit
}

fn is_next(stretch: Stretch, run: Run, is_triangle: bool) -> bool {
    let waits = has_lanes(run.lanes) && !run.forced;
    if kinds_apart() {
        return waits && has_lane(stretch.triangles, first_lane(run.lanes)) == is_triangle;
    }
    return waits;
}

// Visits casters, up to the first of the other kind where kinds are apart.
fn visit_run(view: GpuView, stretch: Stretch, first: Run, is_triangle: bool) -> Run {
    var run = first;
    loop {
        if is_next(stretch, run, is_triangle) {
            run.last = first_lane(run.lanes);
            run.forced = visit_lane(view, stretch.payload, run.last, is_triangle);
            if is_whole() {
                run.lanes = without_first(run.lanes);
            }
        }
        if !is_next(stretch, run, is_triangle) {
            break;
        }
    }
    return run;
}

// Moves on behind the first `count` pairs of a stretch. Returns true at the end of the slab.
fn move_on(stretch: Stretch, count: u32, block: Block) -> bool {
    base += count;
    return count == stretch.count && count < block.size;
}

// Visits pairs up to the end of the slab, or up to a hit that must be inserted. Returns true at the end of
// the slab.
fn visit_stretches(view: GpuView, end: u32, block: Block) -> bool {
    var whole = false;
    var run = Run(ALL_LANES, 0u, false);
    loop {
        var stretch: Stretch;
        var meets_triangle = false;
        // Where kinds are apart, up to the next triangle.
        loop {
            stretch = fetch(view, end, block);
            run.lanes &= stretch.ballot;
            run = visit_run(view, stretch, run, !HAS_PARTICLES);
            meets_triangle = has_lanes(run.lanes);
            if !meets_triangle && !run.forced {
                whole = move_on(stretch, stretch.count, block);
                run.lanes = select(ALL_LANES, vec2(0u), whole);
            }
            if whole | run.forced | meets_triangle {
                break;
            }
        }
        if kinds_apart() {
            run = visit_run(view, stretch, run, true);
        }
        if run.forced {
            whole = move_on(stretch, run.last + u32(is_whole()), block);
        }
        if whole | run.forced {
            break;
        }
    }
    return whole;
}

// Visits all slabs. Merges are outside the loop that inserts, because most insertions need none.
fn visit_slabs(view: GpuView, end: u32, block: Block) {
    var whole = false;
    var again = false;  // a volume's ramp ends at the next hit
    var is_end = false; // of all slabs
    loop {
        var merges = false;
        loop {
            if !again {
                whole = visit_stretches(view, end, block);
            }
            flush();
            merges = subgroupAny(must_merge());
            again = HAS_VOLUMES && has_casters && !again;
            if whole && !again {
                slab = next_slab(slab, base, max(end, 1u));
                is_end = base >= end || subgroupAll(settled(key_depth(slab.key)));
            }
            if is_end | merges {
                break;
            }
        }
        if merges {
            merge();
        }
        if is_end {
            break;
        }
    }
    base = end;
}

fn walk(view: GpuView, first: u32, end: u32) {
    let block = subgroup_block();
    base = first;
    slab = first_slab(first, end);
    find_steps(first, end);
    var step = 0u; // of the steps behind all pairs
    loop {
        visit_slabs(view, end, block);
        if step == steps_behind {
            break;
        }
        open_behind(view, step);
        step += 1u;
    }
}
