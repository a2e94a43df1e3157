// Walks a tile's pairs front to back, a slab at a time: every lane of a subgroup fetches one
// footprint and tests it against the subgroup's block of texels; those that touch it are visited by
// all lanes. CPU twin: src/reference/curve/tile.rs, `walk`.

import package::curve::gather::{SLAB_PAIRS, corner, flush, settled, slab_count};
import package::curve::pair_key::pair_key;
import package::curve::volumes::rest_steps;
import package::hit::reach::touches_box;
import package::records::footprint::{footprint_key, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import choice::pairs::pair_footprint;
import choice::store::open_rest;
import choice::visit::{join_waiting, visit, waiting_steps};

fn walk(view: GpuView, first: u32, end: u32) {
    let lane = subgroupExclusiveAdd(1u);
    let all_lanes = subgroupBallot(true);
    let size = countOneBits(all_lanes.x) + countOneBits(all_lanes.y);
    // The block of texels, as in wgsl/walk/subgroup.wgsl.
    let texel = vec2<u32>(corner);
    let lo = vec2<f32>(subgroupBroadcastFirst(texel)) + 0.5;
    let hi = vec2<f32>(subgroupShuffle(texel, size - 1u)) + vec2(0.5, 3.5);
    var base = first;
    var slab_first = first;
    var slab_key = 0u;
    var reach = 0u;
    if first < end {
        slab_key = pair_key(first);
        reach = (pair_key(end - 1u) - slab_key) / slab_count();
    }
    var rests = 0u;
    // Drivers take both sides of a branch, but they leave loops: insertion into the curves is outside of
    // the loop that visits.
    loop {
        var whole = false;
        var forced = false;
        var key = 0u;
        while !whole && !forced {
            let index = base + lane;
            // An empty tile has no pair, but the load needs a valid index.
            let pair = min(index, max(end, 1u) - 1u);
            let id = pair_footprint(pair);
            let footprint = load_footprint(id);
            key = footprint_key(footprint);
            let slab = index < end && index - slab_first < SLAB_PAIRS && key - slab_key <= reach;
            let touches = slab && touches_box(view, footprint, lo, hi);
            let in_slab = subgroupBallot(slab);
            let count = countOneBits(in_slab.x) + countOneBits(in_slab.y);
            let ballot = subgroupBallot(touches);
            var low = ballot.x;
            var high = ballot.y;
            var j = 0u;
            while (low | high) != 0u && !forced {
                if low != 0u {
                    j = firstTrailingBit(low);
                    low &= low - 1u;
                } else {
                    j = 32u + firstTrailingBit(high);
                    high &= high - 1u;
                }
                let now = visit(view, load_footprint(subgroupShuffle(id, j)));
                forced = subgroupAny(now);
            }
            whole = !forced && count < size;
            base += select(count, j + 1u, forced);
            // The next slab begins where this one ends.
            key = subgroupShuffle(key, min(count, size - 1u));
        }
        flush(whole);
        if whole {
            slab_first = base;
            slab_key = key;
            if rests == waiting_steps() + rest_steps() {
                break;
            }
            if base >= end || subgroupAll(settled(key_depth(key))) {
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
