// Walks a tile's pairs front to back, a subgroup at a time: every lane fetches one footprint and tests it
// against the subgroup's block of texels; those that touch it are visited by all lanes. A candidate defines
// how a lane tests and broadcasts its own; the state defines `visit`, and when to stop in `settled`.

import package::bind::loaded::pairs;
import package::records::footprint::front_depth;
import package::records::footprint_loaded::load_footprint;
import package::records::record::record_texel;
import package::records::view::GpuView;
import choice::candidate::{candidate, touches, visit_lane};
import choice::state::{ROWS, corner, settled};

fn walk(view: GpuView, first: u32, end: u32) {
    let lane = subgroupExclusiveAdd(1u);
    let all_lanes = subgroupBallot(true);
    let size = countOneBits(all_lanes.x) + countOneBits(all_lanes.y);
    // The subgroup's block of texels, centre to centre: lanes follow each other in rows of blocks, so the
    // first and the last lane hold its corners. (As integers: LLVM 15 cannot broadcast a float.)
    let texel = vec2<u32>(corner);
    let lo = vec2<f32>(subgroupBroadcastFirst(texel)) + 0.5;
    let hi = vec2<f32>(subgroupShuffle(texel, size - 1u)) + vec2(0.5, f32(ROWS) - 0.5);
    for (var base = first; base < end; base += size) {
        let pair = min(base + lane, end - 1u);
        let id = textureLoad(pairs, record_texel(pair)).g;
        let footprint = load_footprint(id);
        let own = candidate(id, footprint);
        let ballot = subgroupBallot(base + lane < end && touches(view, own, lo, hi));
        var low = ballot.x;
        var high = ballot.y;
        while (low | high) != 0u {
            var j: u32;
            if low != 0u {
                j = firstTrailingBit(low);
                low &= low - 1u;
            } else {
                j = 32u + firstTrailingBit(high);
                high &= high - 1u;
            }
            visit_lane(view, own, j);
        }
        // Later pairs are no nearer than this stretch's first one.
        if subgroupAll(settled(subgroupShuffle(front_depth(footprint), 0u))) {
            break;
        }
    }
}
