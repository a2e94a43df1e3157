// Records from textures: where buffers cannot be bound whole, or the adapter reads them slowly. Casters
// that kernels have written were copied there.

import package::bind::loaded::histograms;
import package::bind::sampled::{casters, footprints, keys, pairs, rects, setups, sorted, tiles};
import package::records::record::{CasterRecord, FootprintRecord, record_texel};
import package::records::tile::{Tile, TileRecord, unpacked_tile};

const CASTER_TEXELS: u32 = 2u;
const FOOTPRINT_TEXELS: u32 = 2u;

fn caster_record(index: u32) -> CasterRecord {
    let at = CASTER_TEXELS * index;
    let place = bitcast<vec4<f32>>(textureLoad(casters, record_texel(at), 0));
    let look = textureLoad(casters, record_texel(at + 1u), 0);
    return CasterRecord(place.xyz, place.w, look.x, look.y, look.z, look.w);
}

fn footprint_record(index: u32) -> FootprintRecord {
    let at = FOOTPRINT_TEXELS * index;
    let bounds = bitcast<vec4<f32>>(textureLoad(footprints, record_texel(at), 0));
    return FootprintRecord(bounds, textureLoad(footprints, record_texel(at + 1u), 0));
}

// A texel of a setup: a triangle's (wgsl/records/footprint.wgsl) or a Gaussian's (wgsl/records/caster.wgsl).
fn setup_words(index: u32) -> vec4<u32> {
    return textureLoad(setups, record_texel(index), 0);
}

// Tiles of a footprint (wgsl/records/tile.wgsl).
fn rect_record(footprint: u32) -> vec2<u32> {
    return textureLoad(rects, record_texel(footprint), 0).xy;
}

// Depth key and footprint, before the sort; or words of bands (wgsl/bin/parts.wgsl).
fn key_record(footprint: u32) -> vec2<u32> {
    return textureLoad(keys, record_texel(footprint), 0).xy;
}

// Depth key and footprint, front to back.
fn sorted_record(index: u32) -> vec2<u32> {
    return textureLoad(sorted, record_texel(index), 0).xy;
}

// Tile and footprint; to a sort, key and value.
fn pair_record(index: u32) -> vec2<u32> {
    return textureLoad(pairs, record_texel(index), 0).xy;
}

fn tile_at(index: u32) -> Tile {
    let words = textureLoad(tiles, record_texel(index), 0);
    return unpacked_tile(TileRecord(words.x, words.y, words.z, words.w));
}

// Count of a digit in a partition of a sort, by column and row (src/stage/sort/mod.rs).
fn count_record(at: vec2<u32>) -> u32 {
    return textureLoad(histograms, at).x;
}

// At least as many rows as counts have.
fn count_rows() -> u32 {
    return textureDimensions(histograms).y;
}
