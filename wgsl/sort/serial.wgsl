// sort on software adapters: runs of pairs, one after another. Rust: src/stage/sort/mod.rs.

import package::bind::uniform::sort_pass;
import package::sort::sort::pair_count;
import choice::digits::DIGITS;
import choice::records::pair_record;
import choice::writes::{written_rows, write_count};

// Runs: each invocation owns one, in order, so a private counter per digit keeps the sort stable.

override WORKGROUP_SIZE: u32;
override RUN_MIN: u32;    // pairs; below it a run's counters cost more than its pairs
override RUN_USUAL: u32;  // pairs; longer runs gain nothing
override RUN_TARGET: u32; // runs that keep the cores busy
override RUN_LIMIT: u32;  // runs in a row of the histograms

const STEP: u32 = 4u; // pairs per loop step: spreads the loop's own cost

fn run_length(count: u32) -> u32 {
    let usual = clamp(ceil_div(count, RUN_TARGET), RUN_MIN, RUN_USUAL);
    let length = max(usual, ceil_div(count, RUN_LIMIT));
    return ceil_div(length, STEP) * STEP;
}

fn ceil_div(a: u32, b: u32) -> u32 {
    return (a + b - 1u) / b;
}

// sort_serial_count: histogram of the digits of each run. One invocation per run.
@compute @workgroup_size(WORKGROUP_SIZE)
fn sort_serial_count(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = pair_count();
    let length = run_length(count);
    let begin = min(id.x * length, count);
    let end = min(begin + length, count);
    let shift = sort_pass.shift;
    let mask = sort_pass.digit_count - 1u;

    var counters: array<u32, DIGITS>;
    var i = begin;
    for (; i + STEP <= end; i += STEP) {
        let key0 = pair_record(i).x;
        let key1 = pair_record(i + 1u).x;
        let key2 = pair_record(i + 2u).x;
        let key3 = pair_record(i + 3u).x;
        counters[(key0 >> shift) & mask] += 1u;
        counters[(key1 >> shift) & mask] += 1u;
        counters[(key2 >> shift) & mask] += 1u;
        counters[(key3 >> shift) & mask] += 1u;
    }
    for (; i < end; i += 1u) {
        let key = pair_record(i).x;
        counters[(key >> shift) & mask] += 1u;
    }
    let digits = min(sort_pass.digit_count, written_rows());
    for (var digit = 0u; digit < digits; digit += 1u) {
        write_count(vec2(id.x, digit), counters[digit]);
    }
}
