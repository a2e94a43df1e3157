// The work of one tile. Rust: `Tile` and `Segment` in src/stage/bin.rs.
struct Tile {
    first: u32, // of its pairs
    end: u32,
    view: u32,
    merged: u32, // 1: several workgroups add to it, `resolve` finishes it
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
