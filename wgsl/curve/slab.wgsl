// Slabs: runs of a segment's pairs, the same for all texels. A walk may end behind each. CPU reference:
// crates/gobo-reference/src/curve/tile.rs, `walk`.

import package::features::NODES;
import package::records::footprint::footprint_key;
import package::records::footprint_loaded::load_footprint;
import choice::pairs::pair_footprint;

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
    return footprint_key(load_footprint(pair_footprint(pair)));
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
