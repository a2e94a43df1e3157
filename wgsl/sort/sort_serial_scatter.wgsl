// sort_serial_scatter: moves each pair to its position by digit. One invocation per run. Rust:
// src/stage/sort/mod.rs.

import package::bind::loaded::{histograms, pairs};
import package::bind::stored::sorted_pairs;
import package::bind::uniform::sort_pass;
import package::sort::serial::{STEP, WORKGROUP_SIZE, run_length};
import package::sort::sort::{TOTAL_ROW, pair_count, texel_from_pair};
import choice::digits::DIGITS;

// Position of this run's next pair with that digit.
var<private> offsets: array<u32, DIGITS>;

fn store(pair: vec4<u32>, digit: u32) {
    let slot = offsets[digit];
    offsets[digit] = slot + 1u;
    textureStore(sorted_pairs, texel_from_pair(slot), pair);
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
    let digits = min(sort_pass.digit_count, textureDimensions(histograms).y);
    for (var digit = 0u; digit < digits; digit += 1u) {
        offsets[digit] = smaller + textureLoad(histograms, vec2(id.x, digit)).x;
        smaller += textureLoad(histograms, vec2(digit, TOTAL_ROW)).x;
    }
    var i = begin;
    for (; i + STEP <= end; i += STEP) {
        let pair0 = textureLoad(pairs, texel_from_pair(i));
        let pair1 = textureLoad(pairs, texel_from_pair(i + 1u));
        let pair2 = textureLoad(pairs, texel_from_pair(i + 2u));
        let pair3 = textureLoad(pairs, texel_from_pair(i + 3u));
        store(pair0, (pair0.x >> shift) & mask);
        store(pair1, (pair1.x >> shift) & mask);
        store(pair2, (pair2.x >> shift) & mask);
        store(pair3, (pair3.x >> shift) & mask);
    }
    for (; i < end; i += 1u) {
        let pair = textureLoad(pairs, texel_from_pair(i));
        store(pair, (pair.x >> shift) & mask);
    }
}
