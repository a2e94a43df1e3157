// Records that the steps of `bin` share. Rust: src/stage/bin.rs.

import package::features::HAS_GAUSSIANS;
import package::records::outline::is_outlined;
import package::records::tile_rect::WHOLE;

struct BinParams {
    footprint_count: u32,
    run_length: u32,     // footprints that one invocation walks, or one workgroup
    run_count: u32,
    pair_capacity: u32,
    tile_count: u32,
    view_count: u32,
    segment_length: u32, // pairs that one workgroup of `accumulate` walks
    block_runs: u32,     // runs of one workgroup
}

// Keeps counting past every capacity; reset before each batch. Rust: `BatchCounters`.
struct BatchCounters {
    pairs_needed: atomic<u32>,
    pair_count: atomic<u32>,   // pairs that were written
    visible: atomic<u32>,
    scattered: atomic<u32>,    // tiny and overflowed footprints
    overflowed: atomic<u32>,
    segment_count: atomic<u32>,
    merged_count: atomic<u32>, // tiles that several workgroups add to
    disordered: atomic<u32>,   // hits out of order in a curve
    in_parts: atomic<u32>,     // overflowed footprints that went through parts of the tiles
}

struct PartParams {
    room: u32,       // most pairs of a part
    most_parts: u32, // parts that are recorded
}

// llvmpipe allows all loops of one invocation 65,535 turns in total; the footprints of an invocation's run
// and the turns that emit their pairs must stay below. Footprints past this number overflow.
const RUN_PAIRS: u32 = 49152u;

// Number of tiles that the rectangle covers.
fn rect_count(rect: vec2<u32>) -> u32 {
    let width = ((rect.x >> 16u) & 255u) - (rect.x & 255u) + 1u;
    let height = (rect.x >> 24u) - ((rect.x >> 8u) & 255u) + 1u;
    let mask = rect.y & 0xffffu;
    let whole = select(mask, width * height, mask == WHOLE);
    return select(whole, countOneBits(mask), width <= 4u && height <= 4u);
}

// Turns of the loops that emit the `count` tiles of a rectangle: rows of outlines take turns of their own.
fn emit_turns(rect: vec2<u32>, count: u32) -> u32 {
    let rows = (rect.x >> 24u) - ((rect.x >> 8u) & 255u) + 1u;
    return count + select(0u, 2u * rows + 2u, HAS_GAUSSIANS && is_outlined(rect));
}

// Whether the rectangle, without its outline, covers a tile of a view.
fn covers(rect: vec2<u32>, view: u32, tile: vec2<u32>) -> bool {
    let corner = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
    let apart = tile - corner;
    let small = all(last - corner < vec2(4u));
    let bit = 1u << (((apart.y & 3u) * 4u + (apart.x & 3u)) & 15u);
    let mask = rect.y & 0xffffu;
    let inside = all(tile >= corner) && all(tile <= last) && (rect.y >> 16u) == view;
    return inside && (mask & select(0xffffu, bit, small)) != 0u;
}
