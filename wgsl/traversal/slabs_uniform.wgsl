// Walks a tile's pairs front to back, a slab at a time; every invocation visits every pair. The
// core tier, without subgroups. CPU reference: crates/gobo-reference/src/curve/tile.rs, `walk`.

import package::curve::gather::{flush, merge, settled};
import package::curve::list::must_merge;
import package::curve::slab::{
    Slab, find_steps, first_slab, has_casters, is_within, next_slab, open_behind, steps_behind,
};
import package::curve::visit_hits::{is_whole, visit};
import package::features::{HAS_PARTICLES, HAS_VOLUMES};
import package::records::footprint::{footprint_key, key_depth, load_footprint};
import package::records::view::GpuView;
import package::traversal::lane_caster::{kinds_apart, visited};
import choice::records::pair_record;

struct Run {
    pair: u32,    // next to visit
    key: u32,     // its key
    open: bool,   // whether it may be within the slab
    forced: bool, // whether hits must be inserted before it is visited
}

// Visits pairs of a slab, up to the first of the other kind where kinds are apart.
fn visit_run(view: GpuView, slab: Slab, first: Run, end: u32, is_triangle: bool) -> Run {
    var run = first;
    var same = true;
    loop {
        let footprint = load_footprint(pair_record(min(run.pair, end - 1u)).y);
        run.key = footprint_key(footprint);
        run.open = run.open && is_within(slab, run.key);
        if kinds_apart() {
            same = footprint.is_triangle == is_triangle;
        }
        if run.open && same {
            run.forced = visit(view, visited(footprint, is_triangle));
            run.pair += u32(is_whole());
            run.open = run.pair < end && !run.forced;
        }
        if !(run.open & same) {
            break;
        }
    }
    return run;
}

// Visits all slabs. Merges are outside the loop that inserts, because most insertions need none.
fn visit_slabs(view: GpuView, first: u32, end: u32) {
    // An empty tile has no pair, but the load needs a valid index.
    let some = max(end, 1u);
    var slab = first_slab(first, end);
    var base = first;
    var run = Run(base, 0u, base < end, false);
    var again = false;  // a volume's ramp ends at the next hit
    var is_end = false; // of all slabs
    loop {
        loop {
            if !again {
                run = Run(base, 0u, base < end, false);
                loop {
                    run = visit_run(view, slab, run, some, !HAS_PARTICLES);
                    if kinds_apart() {
                        run = visit_run(view, slab, run, some, true);
                    }
                    if !run.open {
                        break;
                    }
                }
                base = run.pair;
            }
            flush();
            again = HAS_VOLUMES && has_casters && !again;
            if !run.forced && !again {
                slab = next_slab(slab, base, some);
                is_end = base >= end || settled(key_depth(slab.key));
            }
            if is_end | must_merge() {
                break;
            }
        }
        if must_merge() {
            merge();
        }
        if is_end {
            break;
        }
    }
}

fn walk(view: GpuView, first: u32, end: u32) {
    var base = first; // next pair
    find_steps(first, end);
    var step = 0u; // of the steps behind all pairs
    loop {
        visit_slabs(view, base, end);
        if step == steps_behind {
            break;
        }
        base = end;
        open_behind(view, step);
        step += 1u;
    }
}
