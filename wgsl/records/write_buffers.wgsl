// Records to buffers.

import package::bind::changed::{
    clipped_rects, footprints, keys, pairs, rects, setups, sorted_pairs, tiles,
};
import package::records::record::FootprintRecord;

fn write_footprint(index: u32, footprint: FootprintRecord) {
    footprints[index] = footprint;
}

fn write_setup_words(index: u32, words: vec4<u32>) {
    setups[index] = words;
}

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

fn write_tile_words(index: u32, words: vec4<u32>) {
    tiles[index] = words;
}
