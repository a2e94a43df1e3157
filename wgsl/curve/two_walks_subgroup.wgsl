// Walks a tile's discs front to back, twice, a subgroup at a time: every lane prepares one and tests it against the
// subgroup's block of texels; all lanes visit those that touch it.

import package::curve::ray::{begin_walk, settled};
import package::curve::ray_nodes::{end_walk, visit_disc, visit_scattered};
import package::hit::disc::{broadcast_disc, disc_touches, prepare_disc};
import package::records::footprint::{footprint_key, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import package::traversal::subgroup_block::{
    Block, block_high, block_low, first_lane, has_lanes, subgroup_block, without_first,
};
import choice::pairs::pair_footprint;

fn visit_pairs(view: GpuView, first: u32, end: u32, block: Block) {
    var base = first;
    var open = first < end;
    while open {
        let pair = base + block.lane;
        let footprint = load_footprint(pair_footprint(min(pair, end - 1u)));
        let disc = prepare_disc(view, footprint);
        let touched = pair < end && disc_touches(view, footprint.bounds, block_low(block), block_high(block));
        for (var lanes = subgroupBallot(touched).xy; has_lanes(lanes); lanes = without_first(lanes)) {
            visit_disc(view, broadcast_disc(disc, first_lane(lanes)));
        }
        let front = key_depth(subgroupShuffle(footprint_key(footprint), block.size - 1u));
        base += block.size;
        open = base < end && !subgroupAll(settled(front));
    }
}

fn walk(view: GpuView, first: u32, end: u32) {
    let block = subgroup_block();
    for (var turn = 0u; turn < 2u; turn += 1u) {
        begin_walk(turn == 1u);
        visit_pairs(view, first, end, block);
        visit_scattered(view);
    }
    end_walk(view);
}
