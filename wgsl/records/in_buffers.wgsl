// Records from the buffers that they were written to.

import package::bind::read::{casters, footprints, histograms, keys, pairs, rects, setups, sorted, tiles};
import package::records::record::{CasterRecord, FootprintRecord, TOTAL_ROW};
import package::records::tile::{Tile, unpacked_tile};

fn caster_record(index: u32) -> CasterRecord {
    return casters[index];
}

fn footprint_record(index: u32) -> FootprintRecord {
    return footprints[index];
}

fn setup_words(index: u32) -> vec4<u32> {
    return setups[index];
}

fn rect_record(footprint: u32) -> vec2<u32> {
    return rects[footprint];
}

fn key_record(footprint: u32) -> vec2<u32> {
    return keys[footprint];
}

fn sorted_record(index: u32) -> vec2<u32> {
    return sorted[index];
}

fn pair_record(index: u32) -> vec2<u32> {
    return pairs[index];
}

fn tile_at(index: u32) -> Tile {
    return unpacked_tile(tiles[index]);
}

fn count_record(at: vec2<u32>) -> u32 {
    return histograms[at.y * (arrayLength(&histograms) / (TOTAL_ROW + 1u)) + at.x];
}

fn count_rows() -> u32 {
    return arrayLength(&histograms);
}
