// Records to textures.

import package::bind::stored::{
    clipped_rects, footprints, keys, pairs, rects, setups, sorted_pairs, tiles,
};
import package::bind::updated::histograms;
import package::records::in_textures::FOOTPRINT_TEXELS;
import package::records::record::{FootprintRecord, record_texel};
import package::records::tile::{Tile, packed_tile};

fn write_footprint(index: u32, footprint: FootprintRecord) {
    let at = FOOTPRINT_TEXELS * index;
    textureStore(footprints, record_texel(at), bitcast<vec4<u32>>(footprint.bounds));
    textureStore(footprints, record_texel(at + 1u), footprint.look);
}

fn write_setup_words(index: u32, words: vec4<u32>) {
    textureStore(setups, record_texel(index), words);
}

fn write_rect(footprint: u32, rect: vec2<u32>) {
    textureStore(rects, record_texel(footprint), vec4(rect, 0u, 0u));
}

fn write_clipped_rect(footprint: u32, rect: vec2<u32>) {
    textureStore(clipped_rects, record_texel(footprint), vec4(rect, 0u, 0u));
}

fn write_key(footprint: u32, key: vec2<u32>) {
    textureStore(keys, record_texel(footprint), vec4(key, 0u, 0u));
}

fn write_pair(index: u32, pair: vec2<u32>) {
    textureStore(pairs, record_texel(index), vec4(pair, 0u, 0u));
}

fn write_sorted_pair(index: u32, pair: vec2<u32>) {
    textureStore(sorted_pairs, record_texel(index), vec4(pair, 0u, 0u));
}

fn write_tile(index: u32, tile: Tile) {
    let it = packed_tile(tile);
    textureStore(tiles, record_texel(index), vec4(it.first, it.end, it.merged, it.place));
}

fn write_count(at: vec2<u32>, count: u32) {
    textureStore(histograms, at, vec4(count, 0u, 0u, 0u));
}

// A count, for kernels that also write some.
fn counted(at: vec2<u32>) -> u32 {
    return textureLoad(histograms, at).x;
}

// `count_rows`, for kernels that write counts.
fn written_rows() -> u32 {
    return textureDimensions(histograms).y;
}
