// sort_serial_scatter: moves each pair to its position by digit. One invocation per run. Rust:
// src/stage/sort/mod.rs.

import package::bind::uniform::sort_pass;
import package::records::record::TOTAL_ROW;
import package::sort::serial::{STEP, WORKGROUP_SIZE, run_length};
import package::sort::sort::pair_count;
import choice::digits::DIGITS;
import choice::records::{count_record, count_rows, pair_record};
import choice::writes::write_sorted_pair;

// Position of this run's next pair with that digit.
var<private> offsets: array<u32, DIGITS>;

fn store(pair: vec2<u32>, digit: u32) {
    let slot = offsets[digit];
    offsets[digit] = slot + 1u;
    write_sorted_pair(slot, pair);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_serial_scatter(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = pair_count();
    let length = run_length(count);
    let begin = min(id.x * length, count);
    let end = min(begin + length, count);
    let shift = sort_pass.shift;
    let mask = sort_pass.digit_count - 1u;

    var smaller = 0u;
    let digits = min(sort_pass.digit_count, count_rows());
    for (var digit = 0u; digit < digits; digit += 1u) {
        offsets[digit] = smaller + count_record(vec2(id.x, digit));
        smaller += count_record(vec2(digit, TOTAL_ROW));
    }
    var i = begin;
    for (; i + STEP <= end; i += STEP) {
        let pair0 = pair_record(i);
        let pair1 = pair_record(i + 1u);
        let pair2 = pair_record(i + 2u);
        let pair3 = pair_record(i + 3u);
        store(pair0, (pair0.x >> shift) & mask);
        store(pair1, (pair1.x >> shift) & mask);
        store(pair2, (pair2.x >> shift) & mask);
        store(pair3, (pair3.x >> shift) & mask);
    }
    for (; i < end; i += 1u) {
        let pair = pair_record(i);
        store(pair, (pair.x >> shift) & mask);
    }
}
