// Walks a tile's soft discs front to back, a slab at a time: every lane of a subgroup prepares one
// disc and tests it against the subgroup's block of texels; those that touch it are visited by all
// lanes. CPU twin: src/reference/curve/tile.rs, `walk`.

import package::curve::gather::{
    SLAB_PAIRS, append_single, corner, few, flush, hit_count, is_single, max_exact_hits, nearest,
    settled, slab_count,
};
import package::curve::pair_key::pair_key;
import package::curve::visit_discs::{count_disc, visit_disc};
import package::hit::disc::{Disc, prepare_disc, touches};
import package::records::footprint::{footprint_key, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::tile_rect::INVISIBLE;
import package::records::view::GpuView;
import package::walk::disc_lanes::{broadcast_disc, first_lane, has_lanes, without_first};
import choice::pairs::pair_footprint;
import choice::store::open_rest;

var<private> base: u32; // next pair
var<private> slab_first: u32;
var<private> slab_key: u32;
var<private> slab_reach: u32;

// A run of pairs, one per lane, up to the end of the slab.
struct Stretch {
    disc: Disc,
    ballot: vec2<u32>, // lanes whose disc touches the block
    count: u32,        // pairs within the slab
    key: u32,          // key of the lane's pair
}

fn fetch(view: GpuView, lane: u32, end: u32, lo: vec2<f32>, hi: vec2<f32>) -> Stretch {
    let index = base + lane;
    // An empty tile has no pair, but the load needs a valid index.
    let pair = min(index, max(end, 1u) - 1u);
    let footprint = load_footprint(pair_footprint(pair));
    let key = footprint_key(footprint);
    let slab = index < end && index - slab_first < SLAB_PAIRS && key - slab_key <= slab_reach;
    let in_slab = subgroupBallot(slab);
    let touching = subgroupBallot(slab && touches(view, footprint.place, lo, hi));
    let count = countOneBits(in_slab.x) + countOneBits(in_slab.y);
    return Stretch(prepare_disc(view, footprint), touching.xy, count, key);
}

fn walk(view: GpuView, first: u32, end: u32) {
    let lane = subgroupExclusiveAdd(1u);
    let all_lanes = subgroupBallot(true);
    let size = countOneBits(all_lanes.x) + countOneBits(all_lanes.y);
    // The block of texels, as in wgsl/walk/subgroup.wgsl.
    let texel = vec2<u32>(corner);
    let lo = vec2<f32>(subgroupBroadcastFirst(texel)) + 0.5;
    let hi = vec2<f32>(subgroupShuffle(texel, size - 1u)) + vec2(0.5, 3.5);
    base = first;
    slab_key = 0u;
    slab_reach = INVISIBLE;
    var front = 0.0;
    while base < end && subgroupAny(any((hit_count <= max_exact_hits()) | (nearest > vec4(front)))) {
        slab_first = base;
        let stretch = fetch(view, lane, end, lo, hi);
        for (var mask = stretch.ballot; has_lanes(mask); mask = without_first(mask)) {
            count_disc(view, broadcast_disc(stretch.disc, first_lane(mask)));
        }
        front = key_depth(subgroupShuffle(stretch.key, max(stretch.count, 1u) - 1u));
        base += stretch.count;
    }
    few = hit_count <= max_exact_hits();
    base = first;
    slab_first = first;
    slab_reach = 0u;
    if first < end {
        slab_key = pair_key(first);
        slab_reach = (pair_key(end - 1u) - slab_key) / slab_count();
    }
    // Drivers execute a loop once at least and take both sides of branches: rare work has loops of its own.
    while base < end && subgroupAny(any(is_single())) {
        for (var whole = false; !whole;) {
            let stretch = fetch(view, lane, end, lo, hi);
            for (var mask = stretch.ballot; has_lanes(mask); mask = without_first(mask)) {
                let placed = visit_disc(view, broadcast_disc(stretch.disc, first_lane(mask)));
                append_single();
            }
            whole = next_stretch(stretch, size);
        }
        flush(true);
        slab_first = base;
    }
    // The last round adds scattered casters behind all pairs.
    loop {
        let rests = base >= end;
        for (var whole = rests; !whole;) {
            let stretch = fetch(view, lane, end, lo, hi);
            for (var mask = stretch.ballot; has_lanes(mask); mask = without_first(mask)) {
                let placed = visit_disc(view, broadcast_disc(stretch.disc, first_lane(mask)));
            }
            whole = next_stretch(stretch, size);
        }
        if rests {
            open_rest(view, 0u);
        }
        flush(true);
        if rests {
            break;
        }
        slab_first = base;
        base = select(base, end, subgroupAll(settled(key_depth(slab_key))));
    }
}

// Returns true at the end of the slab, where the next begins.
fn next_stretch(stretch: Stretch, size: u32) -> bool {
    let key = subgroupShuffle(stretch.key, min(stretch.count, size - 1u));
    base += stretch.count;
    let whole = stretch.count < size;
    slab_key = select(slab_key, key, whole);
    return whole;
}
