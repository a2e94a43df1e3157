// The work of one tile; a texel of `tiles`.

struct Tile {
    first: u32, // of its pairs
    end: u32,
    merged: u32, // not 0: several workgroups share it; 1 + its first segment
    view: u32,
    place: vec2<u32>, // in the view's map [tiles]
}

// A batch has at most 64 views, a map at most 4,096 tiles along an edge.
fn tile_record(tile: Tile) -> vec4<u32> {
    return vec4(tile.first, tile.end, tile.merged, tile.view | (tile.place.x << 8u) | (tile.place.y << 20u));
}

fn tile_of(record: vec4<u32>) -> Tile {
    let place = vec2((record.w >> 8u) & 0xfffu, record.w >> 20u);
    return Tile(record.x, record.y, record.z, record.w & 0xffu, place);
}

// Rust: `Segment` in src/stage/bin.rs.
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
