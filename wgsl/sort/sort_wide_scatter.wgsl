// sort_wide_scatter: moves each pair to its position by digit. One workgroup per block. Rust:
// src/stage/sort/mod.rs.

import package::bind::loaded::{histograms, pairs};
import package::bind::stored::sorted_pairs;
import package::bind::uniform::sort_pass;
import package::sort::sort::{TOTAL_ROW, pair_count, texel_from_pair};
import package::sort::wide::{BLOCK, ROUNDS, WARP_COUNT, WARP_SIZE, WORKGROUP_SIZE, exclusive_sum};

// Per warp and digit: lanes that hold the digit in this round.
var<workgroup> holders: array<atomic<u32>, WARP_COUNT * 256u>;
// Per warp and digit, a warp in each half word: pairs in earlier rounds, later in earlier warps.
// A block is shorter than 2^16, so no half overflows.
var<workgroup> ranked: array<atomic<u32>, WARP_COUNT / 2u * 256u>;
// Position of the block's first pair with that digit.
var<workgroup> offsets: array<u32, 256>;

fn ranked_in(warp: u32, digit: u32) -> u32 {
    return (atomicLoad(&ranked[warp / 2u * 256u + digit]) >> (warp % 2u * 16u)) & 0xffffu;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_wide_scatter(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let count = pair_count();
    if block.x * BLOCK >= count {
        return;
    }
    let shift = sort_pass.shift;
    let mask = sort_pass.digit_count - 1u;
    let warp = lane / WARP_SIZE;
    let bit = 1u << (lane % WARP_SIZE);
    let begin = block.x * BLOCK + warp * ROUNDS * WARP_SIZE + lane % WARP_SIZE;

    // 1. Digit `lane`: the totals of smaller digits and the same digit in earlier blocks.
    var in_all = 0u;
    var in_earlier_blocks = 0u;
    if lane <= mask {
        in_all = textureLoad(histograms, vec2(lane, TOTAL_ROW)).x;
        in_earlier_blocks = textureLoad(histograms, vec2(block.x, lane)).x;
    }
    offsets[lane] = exclusive_sum(lane, in_all) + in_earlier_blocks;

    // 2. Rank each pair among those of its warp with the same digit.
    var held: array<vec2<u32>, ROUNDS>;
    var rank: array<u32, ROUNDS>;
    var before = WARP_COUNT * 256u; // the mask with this lane's bit; none yet
    for (var round = 0u; round < ROUNDS; round += 1u) {
        let i = begin + round * WARP_SIZE;
        let present = i < count;
        var digit = 0u;
        var earlier = 0u;
        // Only its own lane changes a bit, so clearing the last one needs no barrier.
        if before < WARP_COUNT * 256u {
            atomicXor(&holders[before], bit);
            before = WARP_COUNT * 256u;
        }
        if present {
            held[round] = textureLoad(pairs, texel_from_pair(i)).xy;
            digit = (held[round].x >> shift) & mask;
            before = warp * 256u + digit;
            atomicOr(&holders[before], bit);
            earlier = ranked_in(warp, digit);
        }
        workgroupBarrier(); // all lanes hold their digit and have read the earlier rounds
        if present {
            let lanes = atomicLoad(&holders[before]);
            let lower = lanes & (bit - 1u);
            rank[round] = earlier + countOneBits(lower);
            if lower == 0u {
                let added = countOneBits(lanes) << (warp % 2u * 16u);
                atomicAdd(&ranked[warp / 2u * 256u + digit], added);
            }
        }
        workgroupBarrier(); // all have read the masks, and the round is added
    }

    // 3. Digit `lane`: counts of warps -> pairs in earlier warps.
    var sum = 0u;
    for (var pair_of_warps = 0u; pair_of_warps < WARP_COUNT / 2u; pair_of_warps += 1u) {
        let at = pair_of_warps * 256u + lane;
        let both = atomicLoad(&ranked[at]);
        let low = both & 0xffffu;
        atomicStore(&ranked[at], sum | ((sum + low) << 16u));
        sum += low + (both >> 16u);
    }
    workgroupBarrier(); // offsets and earlier warps are known

    // 4. Store.
    for (var round = 0u; round < ROUNDS; round += 1u) {
        if begin + round * WARP_SIZE < count {
            let digit = (held[round].x >> shift) & mask;
            let slot = offsets[digit] + ranked_in(warp, digit) + rank[round];
            textureStore(sorted_pairs, texel_from_pair(slot), vec4(held[round], 0u, 0u));
        }
    }
}
