// Code that all sort kernels share. Rust: `SortPass` in src/stage/sort/mod.rs.

import package::bind::read::counts;
import package::bind::uniform::sort_pass;

const PAIR_ROW: u32 = 4096u;  // pairs per texture row [texels]
const TOTAL_ROW: u32 = 256u;  // histogram row with the totals of the digits

struct SortPass {
    shift: u32,       // of the digit in the key [bits]
    digit_count: u32, // values of the digit, a power of two, at most 256
    capacity: u32,    // [pairs]
    count_index: u32, // of the pair count in `counts`
}

fn pair_count() -> u32 {
    return min(counts[sort_pass.count_index], sort_pass.capacity);
}

fn texel_from_pair(pair_id: u32) -> vec2<u32> {
    return vec2(pair_id % PAIR_ROW, pair_id / PAIR_ROW);
}
