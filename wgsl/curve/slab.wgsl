// Slabs: runs of a segment's pairs, alike for all texels. Hits of soft discs stay open until the end of
// their slab. CPU twin: src/reference/curve/tile.rs, `walk`.

import package::features::NODES;
import package::records::footprint::footprint_key;
import package::records::footprint_loaded::load_footprint;
import choice::pairs::pair_footprint;

const SLAB_PAIRS: u32 = 128u; // at most

struct Slab {
    first: u32, // its first pair
    key: u32,   // depth key of that
    reach: u32, // largest difference of its depth keys
}

// Slabs per segment: the pairs of a slab span at most 1 over this number of their segment's depth range.
fn slab_count() -> u32 {
    return NODES + NODES / 2u;
}

fn pair_key(pair: u32) -> u32 {
    return footprint_key(load_footprint(pair_footprint(pair)));
}

// First slab of the pairs first..end.
fn first_slab(first: u32, end: u32) -> Slab {
    var slab = Slab(first, 0u, 0u);
    if first < end {
        slab.key = pair_key(first);
        slab.reach = (pair_key(end - 1u) - slab.key) / slab_count();
    }
    return slab;
}

// Whether a pair that follows the first of the slab is within it.
fn is_within(slab: Slab, pair: u32, key: u32) -> bool {
    return pair - slab.first < SLAB_PAIRS && key - slab.key <= slab.reach;
}
