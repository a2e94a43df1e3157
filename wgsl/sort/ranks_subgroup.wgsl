// Ranks by ballots: lanes of a subgroup that hold the same digit find each other by its bits, and the first
// of them counts for all (Ashkiani et al. 2016, "GPU Multisplit"). A round needs no barrier. Unlike the
// paper: subgroups with fewer lanes than a team take turns, so that the counters of small subgroups fit into
// workgroup memory.

import package::bind::uniform::sort_pass;
import package::features::WIDE;
import package::scan::prefix::agreed;
import package::sort::wide::{ROUNDS, Share, TEAMS, WORKGROUP_SIZE, half_of, held, ranked, ranked_word, ranks};
import package::traversal::lane::first_lane;
import choice::records::pair_record;

const TEAM_SIZE: u32 = WORKGROUP_SIZE / TEAMS;
const MAX_BITS: u32 = 8u; // of a digit

fn share_of(lane: u32) -> Share {
    let size = subgroupAdd(1u);
    return Share(lane / max(TEAM_SIZE, size), lane / size * ROUNDS * size + lane % size, size);
}

// Lanes among `lanes` that hold the same digit.
fn same_digit(lanes: vec2<u32>, digit: u32) -> vec2<u32> {
    var same = lanes;
    for (var bit = 0u; bit < MAX_BITS; bit += 1u) {
        let own = (digit >> bit) & 1u;
        same &= subgroupBallot(own != 0u).xy ^ vec2(own - 1u);
    }
    return same;
}

// Number of `lanes` before `lane`.
fn lanes_before(lanes: vec2<u32>, lane: u32) -> u32 {
    if WIDE && lane >= 32u {
        return countOneBits(lanes.x) + countOneBits(lanes.y & ((1u << (lane - 32u)) - 1u));
    }
    return countOneBits(lanes.x & ((1u << lane) - 1u));
}

fn lane_count(lanes: vec2<u32>) -> u32 {
    return countOneBits(lanes.x) + select(0u, countOneBits(lanes.y), WIDE);
}

// Ranks the share's pairs from `begin` up to `count`.
fn rank_pairs(lane: u32, share: Share, begin: u32, count: u32) {
    // All subgroups of a workgroup have as many lanes.
    let size = agreed(lane, share.step);
    let own_lane = lane % share.step;
    let own_turn = lane % TEAM_SIZE / share.step;
    for (var turn = 0u; turn * size < TEAM_SIZE; turn += 1u) {
        if own_turn == turn {
            for (var round = 0u; round < ROUNDS; round += 1u) {
                let i = begin + share.first + round * share.step;
                let present = i < count;
                held[round] = pair_record(select(begin, i, present));
                let digit = (held[round].x >> sort_pass.shift) & (sort_pass.digit_count - 1u);
                let lanes = same_digit(subgroupBallot(present).xy, digit);
                let first = select(own_lane, first_lane(lanes), present);
                var word = 0u;
                if present && first == own_lane {
                    let added = lane_count(lanes) << (share.team % 2u * 16u);
                    word = atomicAdd(&ranked[ranked_word(share.team, digit)], added);
                }
                let earlier = half_of(subgroupShuffle(word, first), share.team);
                ranks[round] = earlier + lanes_before(lanes, own_lane);
            }
        }
        workgroupBarrier(); // the team's counters are for the next subgroup
    }
}
