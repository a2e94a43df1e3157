// Slabs: runs of a segment's pairs, the same for all texels. A walk may end behind each. CPU reference:
// crates/gobo-reference/src/curve/tile.rs, `walk`.

import package::curve::visit_hits::{join_waiting, waiting_steps};
import package::features::NODES;
import package::records::footprint::{footprint_key, load_footprint};
import package::records::view::GpuView;
import choice::output::{is_scattered, open_rest, tile_steps};
import choice::records::pair_record;

const SLAB_PAIRS: u32 = 128u; // at most, besides pairs as deep as the last

struct Slab {
    key: u32,   // depth key of its first pair
    last: u32,  // largest depth key that belongs to it
    reach: u32, // largest difference of depth keys
}

// Slabs per segment: the pairs of a slab span at most 1 / `slab_count` of the segment's depth range.
fn slab_count() -> u32 {
    return NODES + NODES / 2u;
}

fn pair_key(pair: u32) -> u32 {
    return footprint_key(load_footprint(pair_record(pair).y));
}

// First slab of the pairs first..end.
fn first_slab(first: u32, end: u32) -> Slab {
    var slab = Slab(0u, 0u, 0u);
    if first < end {
        slab.reach = (pair_key(end - 1u) - pair_key(first)) / slab_count();
        slab = next_slab(slab, first, end);
    }
    return slab;
}

// Slab of the pairs from `first` on; `end`: of the segment, which is not empty.
fn next_slab(slab: Slab, first: u32, end: u32) -> Slab {
    let key = pair_key(min(first, end - 1u));
    let farthest = pair_key(min(first + SLAB_PAIRS, end) - 1u);
    return Slab(key, min(key + slab.reach, farthest), slab.reach);
}

// Whether a pair behind the first of the slab belongs to it.
fn is_within(slab: Slab, key: u32) -> bool {
    return key <= slab.last;
}

// Steps behind a tile's pairs, an insertion each: hits that still wait in order, volumes that contain the
// light, and casters whose pairs did not fit.

var<private> has_casters: bool; // with pairs or without
var<private> steps_behind: u32; // none where no caster is

// `first`, `end`: range of the pairs.
fn find_steps(first: u32, end: u32) {
    has_casters = (first < end) | is_scattered();
    steps_behind = select(0u, waiting_steps() + tile_steps(), has_casters);
}

// Opens the hits of one step, for the next insertion.
fn open_behind(view: GpuView, step: u32) {
    if step < waiting_steps() {
        join_waiting();
    } else {
        open_rest(view, step - waiting_steps());
    }
}
