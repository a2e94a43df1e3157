// Records to buffers.

import package::bind::changed::{clipped_rects, keys, pairs, rects, sorted_pairs};

fn write_rect(footprint: u32, rect: vec2<u32>) {
    rects[footprint] = rect;
}

fn write_clipped_rect(footprint: u32, rect: vec2<u32>) {
    clipped_rects[footprint] = rect;
}

fn write_key(footprint: u32, key: vec2<u32>) {
    keys[footprint] = key;
}

fn write_pair(index: u32, pair: vec2<u32>) {
    pairs[index] = pair;
}

fn write_sorted_pair(index: u32, pair: vec2<u32>) {
    sorted_pairs[index] = pair;
}
