// sort_serial_count: histogram of the digits of each run. One invocation per run. Rust:
// src/stage/sort/mod.rs.

import package::bind::loaded::pairs;
import package::bind::stored::histograms;
import package::bind::uniform::sort_pass;
import package::sort::serial::{STEP, WORKGROUP_SIZE, run_length};
import package::sort::sort::{pair_count, texel_from_pair};
import choice::digits::DIGITS;

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
        let key0 = textureLoad(pairs, texel_from_pair(i)).x;
        let key1 = textureLoad(pairs, texel_from_pair(i + 1u)).x;
        let key2 = textureLoad(pairs, texel_from_pair(i + 2u)).x;
        let key3 = textureLoad(pairs, texel_from_pair(i + 3u)).x;
        counters[(key0 >> shift) & mask] += 1u;
        counters[(key1 >> shift) & mask] += 1u;
        counters[(key2 >> shift) & mask] += 1u;
        counters[(key3 >> shift) & mask] += 1u;
    }
    for (; i < end; i += 1u) {
        let key = textureLoad(pairs, texel_from_pair(i)).x;
        counters[(key >> shift) & mask] += 1u;
    }
    let digits = min(sort_pass.digit_count, textureDimensions(histograms).y);
    for (var digit = 0u; digit < digits; digit += 1u) {
        textureStore(histograms, vec2(id.x, digit), vec4(counters[digit], 0u, 0u, 0u));
    }
}
