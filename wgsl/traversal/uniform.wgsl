// Walks a tile's pairs front to back; every invocation visits every pair. The core tier, without subgroups.
// The accumulator's `settled` ends the walk.

import package::features::HAS_PARTICLES;
import package::records::footprint::{front_depth, load_footprint};
import package::records::view::GpuView;
import package::traversal::lane_caster::{kinds_apart, visited};
import choice::accumulator::{settled, visit};
import choice::records::pair_record;

struct Run {
    pair: u32,  // next to visit
    open: bool, // whether there is one, and it can change something
}

// Visits pairs, up to the first of the other kind where kinds are apart.
fn visit_run(view: GpuView, first: Run, end: u32, is_triangle: bool) -> Run {
    var run = first;
    var same = true;
    loop {
        let id = pair_record(min(run.pair, end - 1u)).y;
        let footprint = load_footprint(id);
        if kinds_apart() {
            same = footprint.is_triangle == is_triangle;
        }
        if run.open && same {
            visit(view, id, visited(footprint, is_triangle));
            run.pair += 1u;
            run.open = run.pair < end && !settled(front_depth(footprint));
        }
        if !(run.open & same) {
            break;
        }
    }
    return run;
}

fn visit_pairs(view: GpuView, first: u32, end: u32) {
    // An empty tile has no pair, but the load needs a valid index.
    let some = max(end, 1u);
    var run = Run(first, first < end);
    loop {
        run = visit_run(view, run, some, !HAS_PARTICLES);
        if kinds_apart() {
            run = visit_run(view, run, some, true);
        }
        if !run.open {
            break;
        }
    }
}

fn walk(view: GpuView, first: u32, end: u32) {
    visit_pairs(view, first, end);
}
