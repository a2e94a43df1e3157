// Parameters, counters and dispatches of a batch, and its unit of work. Rust: `Chunk` in
// src/stage/project.rs, src/stage/bin.rs.

import package::features::HAS_GAUSSIANS;
import package::records::outline::is_outlined;
import package::records::tile::WHOLE;

// A run of casters for one view: the unit of work of `project`.
struct Chunk {
    view: u32,
    first_caster: u32,
    count: u32,           // at most the workgroup's size
    first_footprint: u32,
}

struct ProjectParams {
    chunk_count: u32,
    // 1: tiny particles take the scatter path.
    scatter: u32,
    // Footprint of the first triangle less the index of its setup, modulo 2^32: setups of Gaussians come
    // first.
    first_setup: u32,
    // Footprint of the Gaussian with setup 0, modulo 2^32.
    first_gaussian: u32,
    // 1: the camera's list includes casters without shadows.
    include_non_casters: u32,
    // 1: depth keys of perspective views are distances from the light or the eye.
    by_distance: u32,
}

// Entries of `dispatches`: workgroup counts in x, y, z; in w the number of casters that did not fit, or of
// merged tiles.

const OVERFLOW_DISPATCH: u32 = 0u;
const SEGMENT_DISPATCH: u32 = 1u;
const MERGED_DISPATCH: u32 = 2u;
// Where some footprints did not fit, all footprints of the list go through parts of its tiles
// (wgsl/bin/parts.wgsl).
const PART_COUNT_DISPATCH: u32 = 3u;
const PART_DISPATCH: u32 = 4u;   // one workgroup per tile of the part; w: its first tile
const PARTED_DISPATCH: u32 = 5u; // x: 1 if they do; w: the tile behind the part
const OVERFLOW_SLICES: u32 = 8u; // workgroups that share the tiles of one overflowed footprint

// Number of a workgroup in a dispatch of rows: a row has fewer workgroups than a device's limit.
fn workgroup_number(workgroup: vec3<u32>, workgroups: vec3<u32>) -> u32 {
    return workgroup.y * workgroups.x + workgroup.x;
}

// Records that the steps of `bin` share.
struct BinParams {
    footprint_count: u32,
    run_length: u32,     // footprints that one invocation walks, or one workgroup
    run_count: u32,
    pair_capacity: u32,
    tile_count: u32,
    view_count: u32,
    segment_length: u32, // pairs that one workgroup of `accumulate` walks
    block_runs: u32,     // runs of one workgroup
    adds_scattered: u32, // 1: a tile's walk adds its scattered casters; 0: they make it a merged one
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
    short_tiles: atomic<u32>,  // tiles of curves that got no page
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
