// Walks a tile's soft discs, the usual casters of smoke, front to back, a subgroup at a time. Every lane
// prepares one disc and tests it against the subgroup's block of texels; the discs that touch it are
// broadcast and multiplied into every lane's texels. CPU twin: src/reference/accumulate.rs.

import package::bind::loaded::pairs;
import package::hit::disc::{Disc, prepare_disc, touches};
import package::records::footprint::{footprint_key, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::record::record_texel;
import package::records::view::GpuView;
import package::state::discs::{corner, seeks, settled, visit_behind, visit_disc};
import package::walk::disc_lanes::{broadcast_disc, first_lane, has_lanes, without_first};
import choice::state::ROWS;

struct Stretch {
    disc: Disc,
    ballot: vec2<u32>, // lanes whose disc touches the block
    front: f32,        // no later pair is nearer
}

fn fetch(view: GpuView, pair: u32, end: u32, size: u32, lo: vec2<f32>, hi: vec2<f32>) -> Stretch {
    let footprint = load_footprint(textureLoad(pairs, record_texel(min(pair, end - 1u))).g);
    let front = key_depth(subgroupShuffle(footprint_key(footprint), size - 1u));
    let touched = subgroupBallot(pair < end && touches(view, footprint.place, lo, hi));
    return Stretch(prepare_disc(view, footprint), touched.xy, front);
}

fn walk(view: GpuView, first: u32, end: u32) {
    let lane = subgroupExclusiveAdd(1u);
    let all_lanes = subgroupBallot(true);
    let size = countOneBits(all_lanes.x) + countOneBits(all_lanes.y);
    // The subgroup's block of texels, centre to centre: lanes follow each other in rows of blocks, so the
    // first and the last lane hold its corners. (As integers: LLVM 15 cannot broadcast a float.)
    let texel = vec2<u32>(corner);
    let lo = vec2<f32>(subgroupBroadcastFirst(texel)) + 0.5;
    let hi = vec2<f32>(subgroupShuffle(texel, size - 1u)) + vec2(0.5, f32(ROWS) - 0.5);
    var base = first;
    // Until all texels have their nearest depth.
    for (var sought = true; sought && base < end;) {
        let stretch = fetch(view, base + lane, end, size, lo, hi);
        for (var mask = stretch.ballot; has_lanes(mask); mask = without_first(mask)) {
            visit_disc(view, broadcast_disc(stretch.disc, first_lane(mask)));
        }
        base = select(base + size, end, subgroupAll(settled(stretch.front)));
        sought = subgroupAny(seeks(stretch.front));
    }
    while base < end {
        let stretch = fetch(view, base + lane, end, size, lo, hi);
        for (var mask = stretch.ballot; has_lanes(mask); mask = without_first(mask)) {
            visit_behind(view, broadcast_disc(stretch.disc, first_lane(mask)));
        }
        base = select(base + size, end, subgroupAll(settled(stretch.front)));
    }
}
