// sort_wide_scatter: moves each pair to its position by digit. One workgroup per block. Rust:
// src/stage/sort/mod.rs.

import package::bind::uniform::sort_pass;
import package::records::record::TOTAL_ROW;
import package::sort::sort::pair_count;
import package::sort::wide::{
    BLOCK, FEW_BLOCKS, ROUNDS, TEAMS, WORKGROUP_SIZE, held, histogram_place, ranked, ranked_in, ranks,
};
import choice::ranks::{rank_pairs, share_of};
import choice::records::count_record;
import choice::scan::prefix_sum;
import choice::writes::write_sorted_pair;

// Position of the block's first pair with that digit.
var<workgroup> offsets: array<u32, 256>;

@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_wide_scatter(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let count = pair_count();
    let begin = block.x * BLOCK;
    if begin >= count {
        return;
    }
    let mask = sort_pass.digit_count - 1u;
    let share = share_of(lane);

    // 1. Digit `lane`: the totals of smaller digits and the same digit in earlier blocks.
    var in_all = 0u;
    var in_earlier_blocks = 0u;
    if FEW_BLOCKS {
        for (var begins = 0u; begins < count; begins += BLOCK) {
            let in_block = count_record(histogram_place(begins / BLOCK, lane));
            in_all += select(0u, in_block, lane <= mask);
            in_earlier_blocks += select(0u, in_block, begins < begin);
        }
    } else if lane <= mask {
        in_all = count_record(vec2(lane, TOTAL_ROW));
        in_earlier_blocks = count_record(vec2(block.x, lane));
    }
    offsets[lane] = prefix_sum(lane, in_all).before + in_earlier_blocks;

    // 2. Rank each pair among those of its team with the same digit.
    rank_pairs(lane, share, begin, count);

    // 3. Digit `lane`: counts of teams -> pairs in earlier teams.
    var sum = 0u;
    for (var two_teams = 0u; two_teams < TEAMS / 2u; two_teams += 1u) {
        let at = two_teams * 256u + lane;
        let both = atomicLoad(&ranked[at]);
        let low = both & 0xffffu;
        atomicStore(&ranked[at], sum | ((sum + low) << 16u));
        sum += low + (both >> 16u);
    }
    workgroupBarrier(); // offsets and earlier teams are known

    // 4. Store.
    for (var round = 0u; round < ROUNDS; round += 1u) {
        if begin + share.first + round * share.step < count {
            let digit = (held[round].x >> sort_pass.shift) & mask;
            let slot = offsets[digit] + ranked_in(share.team, digit) + ranks[round];
            write_sorted_pair(slot, held[round]);
        }
    }
}
