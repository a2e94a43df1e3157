// Walks a tile's pairs front to back, a slab at a time; every invocation visits every pair. The
// core tier, without subgroups. CPU twin: src/reference/curve/tile.rs, `walk`.

import package::curve::gather::{
    SLAB_PAIRS, few, flush, hit_count, max_exact_hits, nearest, settled, slab_count,
};
import package::curve::pair_key::pair_key;
import package::curve::volumes::rest_steps;
import package::records::footprint::{footprint_key, front_depth, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import choice::pairs::pair_footprint;
import choice::store::open_rest;
import choice::visit::{count_hits, join_waiting, slabbed, visit, waiting_steps};

fn walk(view: GpuView, first: u32, end: u32) {
    var base = first;
    var front = 0.0;
    while slabbed() && base < end && any((hit_count <= max_exact_hits()) | (nearest > vec4(front))) {
        let footprint = load_footprint(pair_footprint(base));
        count_hits(view, footprint);
        front = front_depth(footprint);
        base += 1u;
    }
    few = hit_count <= max_exact_hits();
    base = first;
    var slab_first = first;
    var slab_key = 0u;
    var reach = 0u;
    if first < end {
        slab_key = pair_key(first);
        reach = (pair_key(end - 1u) - slab_key) / slab_count();
    }
    var rests = 0u;
    loop {
        var whole = true;
        var key = 0u;
        while base < end {
            let footprint = load_footprint(pair_footprint(base));
            key = footprint_key(footprint);
            if base - slab_first >= SLAB_PAIRS || key - slab_key > reach {
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
            slab_first = base;
            slab_key = key;
            if rests == waiting_steps() + rest_steps() {
                break;
            }
            if base >= end || settled(key_depth(key)) {
                base = end;
                if rests < waiting_steps() {
                    join_waiting();
                } else {
                    open_rest(view, rests - waiting_steps());
                }
                rests += 1u;
            }
        }
    }
}
