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

// The tile that a workgroup takes. A software driver gives each of two cores one half
// of the dispatch: runs of neighbours go to them in turns. (Runs, because stores that follow each
// other in memory are many times faster.)
fn interleaved(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    let i = workgroup.y * workgroups.x + workgroup.x;
    let count = workgroups.x * workgroups.y;
    let half_count = count / 2u;
    let second = i >= half_count;
    let place = select(i, i - half_count, second);
    let whole = count / (2u * RUN) * RUN; // of each half, in whole runs
    let run = 2u * (place - place % RUN) + place % RUN + select(0u, RUN, second);
    return select(select(i + whole, i, second), run, place < whole);
}

const RUN: u32 = 64u; // tiles

const SEGMENT_LENGTH: u32 = 2048u; // pairs; Rust: src/stage/bin.rs

fn segment_count(tile: Tile) -> u32 {
    return (tile.end - tile.first + SEGMENT_LENGTH - 1u) / SEGMENT_LENGTH;
}
