// The work of one tile: a texel of `tiles`, at the tile's index, or, in a part of the tiles, at its index in
// the part.

import package::records::view::GpuView;

struct Tile {
    first: u32, // of its pairs
    end: u32,
    merged: u32, // 0, or 1 + its first segment if several workgroups share the tile
    view: u32,
    position: vec2<u32>, // in the view's map [tiles]
}

// A batch has at most 64 views, a map at most 4,096 tiles along an edge.
fn tile_record(tile: Tile) -> vec4<u32> {
    return vec4(
        tile.first,
        tile.end,
        tile.merged,
        tile.view | (tile.position.x << 8u) | (tile.position.y << 20u),
    );
}

fn tile_of(record: vec4<u32>) -> Tile {
    let position = vec2((record.w >> 8u) & 0xfffu, record.w >> 20u);
    return Tile(record.x, record.y, record.z, record.w & 0xffu, position);
}

// Number of a tile in its batch.
fn tile_number_of(view: GpuView, tile: Tile) -> u32 {
    return view.first_tile + tile.position.y * view.tiles_x + tile.position.x;
}

// Rust: `Segment` in src/stage/bin.rs.
struct Segment {
    tile: u32,
    first: u32, // of its pairs
    end: u32,
    source: u32, // its view, and from bit 8 the index of its tile's record in `tiles`
}

fn segment_view(segment: Segment) -> u32 {
    return segment.source & 0xffu;
}

fn segment_record(segment: Segment) -> u32 {
    return segment.source >> 8u;
}

const SEGMENT_LENGTH: u32 = 2048u; // pairs; Rust: src/stage/bin.rs

fn segment_count(tile: Tile) -> u32 {
    return (tile.end - tile.first + SEGMENT_LENGTH - 1u) / SEGMENT_LENGTH;
}
