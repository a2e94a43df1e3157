// Ranks by bit masks in workgroup memory. A team is 32 invocations, whatever the hardware's subgroups are.

import package::bind::uniform::sort_pass;
import package::sort::wide::{
    ROUNDS, Share, TEAMS, WORKGROUP_SIZE, held, ranked, ranked_in, ranked_word, ranks,
};
import choice::records::pair_record;

const TEAM_SIZE: u32 = WORKGROUP_SIZE / TEAMS; // bits of a mask

// Per team and digit: lanes that hold the digit in this round.
var<workgroup> holders: array<atomic<u32>, TEAMS * 256u>;

fn share_of(lane: u32) -> Share {
    let team = lane / TEAM_SIZE;
    return Share(team, team * ROUNDS * TEAM_SIZE + lane % TEAM_SIZE, TEAM_SIZE);
}

// Ranks the share's pairs from `begin` up to `count`.
fn rank_pairs(lane: u32, share: Share, begin: u32, count: u32) {
    let team = share.team;
    let bit = 1u << (lane % TEAM_SIZE);
    var before = TEAMS * 256u; // the mask with this lane's bit; none yet
    for (var round = 0u; round < ROUNDS; round += 1u) {
        let i = begin + share.first + round * share.step;
        let present = i < count;
        var digit = 0u;
        var earlier = 0u;
        // Only the lane itself changes its bit, so clearing the last one needs no barrier.
        if before < TEAMS * 256u {
            atomicXor(&holders[before], bit);
            before = TEAMS * 256u;
        }
        if present {
            held[round] = pair_record(i);
            digit = (held[round].x >> sort_pass.shift) & (sort_pass.digit_count - 1u);
            before = team * 256u + digit;
            atomicOr(&holders[before], bit);
            earlier = ranked_in(team, digit);
        }
        workgroupBarrier(); // all lanes hold their digit and have read the earlier rounds
        if present {
            let lanes = atomicLoad(&holders[before]);
            let lower = lanes & (bit - 1u);
            ranks[round] = earlier + countOneBits(lower);
            if lower == 0u {
                atomicAdd(&ranked[ranked_word(team, digit)], countOneBits(lanes) << (team % 2u * 16u));
            }
        }
        workgroupBarrier(); // all have read the masks, and the round is added
    }
}
