// Records to buffers.

import package::bind::changed::{keys, pairs, sorted_pairs};

fn write_key(footprint: u32, key: vec2<u32>) {
    keys[footprint] = key;
}

fn write_pair(index: u32, pair: vec2<u32>) {
    pairs[index] = pair;
}

fn write_sorted_pair(index: u32, pair: vec2<u32>) {
    sorted_pairs[index] = pair;
}
