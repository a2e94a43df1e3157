// sort on GPUs: blocks of pairs. Rust: src/stage/sort/mod.rs.

import package::bind::uniform::sort_pass;
import package::sort::sort::pair_count;
import choice::records::pair_record;
import choice::writes::write_count;

// Blocks: each workgroup owns one. A *team* is some consecutive invocations that count together, and its
// pairs are consecutive; `choice::ranks` assigns them to invocations.

// Whether each block sums up the counts of the others by itself, which pays where they are few. Their
// histograms are then in rows of the digits.
override FEW_BLOCKS: bool = false;

const WORKGROUP_SIZE: u32 = 256u;
const TEAMS: u32 = 8u;      // at most
const ROUNDS: u32 = 16u;    // pairs per invocation
const BLOCK: u32 = WORKGROUP_SIZE * ROUNDS; // [pairs]

// Pairs of a block that an invocation sorts: the pair `first` and every `step`-th from it.
struct Share {
    team: u32,
    first: u32,
    step: u32,
}

// The invocation's pairs, and for each the number of pairs with the same digit before it in the team.
var<private> held: array<vec2<u32>, ROUNDS>;
var<private> ranks: array<u32, ROUNDS>;

// Per team and digit, a team in each half word: the team's pairs, later those of earlier teams. A block has
// fewer than 2^16 pairs, so no half overflows.
var<workgroup> ranked: array<atomic<u32>, TEAMS / 2u * 256u>;

// Column and row of a block's count of a digit.
fn histogram_place(block: u32, digit: u32) -> vec2<u32> {
    return select(vec2(block, digit), vec2(digit, block), FEW_BLOCKS);
}

fn half_of(word: u32, team: u32) -> u32 {
    return (word >> (team % 2u * 16u)) & 0xffffu;
}

fn ranked_word(team: u32, digit: u32) -> u32 {
    return team / 2u * 256u + digit;
}

fn ranked_in(team: u32, digit: u32) -> u32 {
    return half_of(atomicLoad(&ranked[ranked_word(team, digit)]), team);
}

var<workgroup> counters: array<atomic<u32>, 256>;

// sort_wide_count: histogram of the digits of each block. One workgroup per block.
@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_wide_count(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let count = pair_count();
    let begin = block.x * BLOCK;
    if begin >= count {
        return;
    }
    let end = min(begin + BLOCK, count);
    let shift = sort_pass.shift;
    let mask = sort_pass.digit_count - 1u;
    // Counting does not depend on order, so consecutive lanes read consecutive pairs.
    for (var i = begin + lane; i < end; i += WORKGROUP_SIZE) {
        let key = pair_record(i).x;
        atomicAdd(&counters[(key >> shift) & mask], 1u);
    }
    workgroupBarrier(); // all pairs are counted
    if lane <= mask {
        let in_block = atomicLoad(&counters[lane]);
        write_count(histogram_place(block.x, lane), in_block);
    }
}
