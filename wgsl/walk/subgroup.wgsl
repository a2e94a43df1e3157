// Walks a tile's pairs front to back, a subgroup at a time: every lane makes a candidate of one footprint
// and tests it against the subgroup's block of texels; all lanes visit those that touch it. The state says
// in `settled` when to stop.

import package::bind::loaded::pairs;
import package::records::footprint::{footprint_key, key_depth};
import package::records::footprint_loaded::load_footprint;
import package::records::record::record_texel;
import package::records::view::GpuView;
import package::walk::subgroup_block::{first_lane, has_lanes, subgroup_block, without_first};
import choice::candidate::{candidate_of, offer_of, touches, visit_lane};
import choice::state::settled;

fn walk(view: GpuView, first: u32, end: u32) {
    let block = subgroup_block();
    var front = 0.0; // no pair from `base` on is nearer
    for (var base = first; base < end; base += block.size) {
        let pair = base + block.lane;
        let id = textureLoad(pairs, record_texel(min(pair, end - 1u))).g;
        let footprint = load_footprint(id);
        let candidate = candidate_of(id, footprint);
        let ballot = subgroupBallot(pair < end && touches(view, candidate, block.lo, block.hi));
        let offer = offer_of(view, candidate, front);
        for (var lanes = ballot.xy; has_lanes(lanes); lanes = without_first(lanes)) {
            visit_lane(view, offer, first_lane(lanes));
        }
        front = key_depth(subgroupShuffle(footprint_key(footprint), block.size - 1u));
        if subgroupAll(settled(front)) {
            break;
        }
    }
}
