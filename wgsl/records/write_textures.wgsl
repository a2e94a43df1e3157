// Records to textures.

import package::bind::stored::{clipped_rects, keys, pairs, rects, sorted_pairs};
import package::records::record::record_texel;

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
