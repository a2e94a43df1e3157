// The work of one tile. Rust: `Tile` and `Segment` in src/stage/bin.rs.
struct Tile {
    first: u32, // of its pairs
    end: u32,
    view: u32,
    merged: u32, // not 0: several workgroups share it; 1 + its first segment
}

struct Segment {
    tile: u32,
    first: u32, // of its pairs
    end: u32,
    view: u32,
}

// The tile that workgroup `i` of `count` takes. Neighbours go to different halves of the dispatch:
// a software driver gives each core one half.
fn interleaved(i: u32, count: u32) -> u32 {
    let half_count = (count + 1u) / 2u;
    return select(2u * (i - half_count) + 1u, 2u * i, i < half_count);
}

const SEGMENT_LENGTH: u32 = 2048u; // pairs; Rust: src/stage/bin.rs

fn segment_count(tile: Tile) -> u32 {
    return (tile.end - tile.first + SEGMENT_LENGTH - 1u) / SEGMENT_LENGTH;
}
