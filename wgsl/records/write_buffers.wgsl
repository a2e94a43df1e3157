// Records to buffers.

import package::bind::changed::{
    clipped_rects, footprints, histograms, keys, pairs, rects, setups, sorted_pairs, tiles,
};
import package::records::record::{FootprintRecord, TOTAL_ROW};
import package::records::tile::{Tile, packed_tile};

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

fn write_tile(index: u32, tile: Tile) {
    tiles[index] = packed_tile(tile);
}

fn histogram_index(at: vec2<u32>) -> u32 {
    return at.y * (arrayLength(&histograms) / (TOTAL_ROW + 1u)) + at.x;
}

fn write_count(at: vec2<u32>, count: u32) {
    histograms[histogram_index(at)] = count;
}

fn counted(at: vec2<u32>) -> u32 {
    return histograms[histogram_index(at)];
}

fn written_rows() -> u32 {
    return arrayLength(&histograms);
}
