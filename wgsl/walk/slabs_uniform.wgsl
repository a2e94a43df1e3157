// Walks a tile's pairs front to back, a slab at a time; every invocation visits every pair. The
// core tier, without subgroups. CPU twin: src/reference/curve/tile.rs, `walk`.

import package::curve::behind::{open_behind, steps_behind};
import package::curve::gather::{end_count, flush, is_counting, settled};
import package::curve::slab::{first_slab, is_within};
import package::records::footprint::{footprint_key, front_depth, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import choice::pairs::pair_footprint;
import choice::visit::{count_hits, slabbed, visit};

fn walk(view: GpuView, first: u32, end: u32) {
    var base = first; // next pair
    var front = 0.0;
    while slabbed() && base < end && is_counting(front) {
        let footprint = load_footprint(pair_footprint(base));
        count_hits(view, footprint);
        front = front_depth(footprint);
        base += 1u;
    }
    end_count();
    base = first;
    var slab = first_slab(first, end);
    var step = 0u; // behind all pairs
    loop {
        var whole = true;
        var key = 0u;
        while base < end {
            let footprint = load_footprint(pair_footprint(base));
            key = footprint_key(footprint);
            if !is_within(slab, base, key) {
                break;
            }
            base += 1u;
            if visit(view, footprint) {
                whole = false;
                break;
            }
        }
        flush(whole);
        if whole {
            slab.first = base;
            slab.key = key;
            if step == steps_behind() {
                break;
            }
            if base >= end || settled(key_depth(key)) {
                base = end;
                open_behind(view, step);
                step += 1u;
            }
        }
    }
}
