// The work of one tile: in `tiles` at the tile's index, or, in a part of the tiles, at its index in the part.
// Rust: `TileRect` in src/records/footprint.rs; CPU reference:
// crates/gobo-reference/src/project.rs.

import package::records::view::{GpuView, TILE_SIZE};

struct Tile {
    first: u32, // of its pairs
    end: u32,
    merged: u32, // 0, or 1 + its first segment if several workgroups share the tile
    view: u32,
    position: vec2<u32>, // in the view's map [tiles]
    scattered: bool, // whether some of its casters have no pairs
}

// A tile as stored.
struct TileRecord {
    first: u32,
    end: u32,
    merged: u32,
    place: u32, // the view, the position, and whether casters were scattered to it
}

const SCATTERED_BIT: u32 = 0x80u;

// A batch has at most 64 views, a map at most 4,096 tiles along an edge.
fn packed_tile(tile: Tile) -> TileRecord {
    let place = tile.view | (tile.position.x << 8u) | (tile.position.y << 20u);
    let scattered = select(0u, SCATTERED_BIT, tile.scattered);
    return TileRecord(tile.first, tile.end, tile.merged, place | scattered);
}

fn unpacked_tile(it: TileRecord) -> Tile {
    let position = vec2((it.place >> 8u) & 0xfffu, it.place >> 20u);
    let scattered = (it.place & SCATTERED_BIT) != 0u;
    return Tile(it.first, it.end, it.merged, it.place & (SCATTERED_BIT - 1u), position, scattered);
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
    source: u32, // its view, and whether it is the first and the last of its tile
}

// All segments of a batch, behind their number.
struct Segments {
    @size(16) count: u32,
    all: array<Segment>,
}

// The same, while they are counted.
struct CountedSegments {
    @size(16) count: atomic<u32>,
    all: array<Segment>,
}

const FIRST_SEGMENT: u32 = 0x100u;
const LAST_SEGMENT: u32 = 0x200u;

fn segment_view(segment: Segment) -> u32 {
    return segment.source & 0xffu;
}

fn is_first_segment(segment: Segment) -> bool {
    return (segment.source & FIRST_SEGMENT) != 0u;
}

fn is_last_segment(segment: Segment) -> bool {
    return (segment.source & LAST_SEGMENT) != 0u;
}

const SEGMENT_LENGTH: u32 = 2048u; // pairs; Rust: src/stage/bin.rs

fn segment_count(tile: Tile) -> u32 {
    return (tile.end - tile.first + SEGMENT_LENGTH - 1u) / SEGMENT_LENGTH;
}

const SLACK: f32 = 0.015625; // around a footprint's box, so that rounding never loses a texel
// Mask of a rectangle larger than 4x4 whose tiles are all touched; 1..WHOLE is the number of tiles that its
// outline touches.
const WHOLE: u32 = 0xffffu;
const INVISIBLE: u32 = 0xffffu; // key of a caster that touches no texel
// Corners of a footprint on the scatter path; it has no tiles.
const SCATTERED: u32 = 0xffffffffu;

// First of the 2x2 texels around `center` that a scattered caster may touch.
fn scatter_texel(center: vec2<f32>) -> vec2<f32> {
    return floor(center - 0.5);
}

fn is_scattered(rect: vec2<u32>) -> bool {
    return rect.x == SCATTERED && (rect.y & 0xffffu) == 0u;
}

// All tiles of a footprint's box `lo`..`hi` [texels]: (corners, mask and view); (0, 0) for no tile.
fn box_rect(size: vec2<f32>, view_index: u32, lo: vec2<f32>, hi: vec2<f32>) -> vec2<u32> {
    // Texel i has its centre at i + 0.5.
    let first_texel = max(ceil(lo - (0.5 + SLACK)), vec2(0.0));
    let last_texel = min(floor(hi - (0.5 - SLACK)), size - 1.0);
    // Written so that a NaN is outside.
    if !(first_texel.x <= last_texel.x && first_texel.y <= last_texel.y) {
        return vec2(0u);
    }
    let first = vec2<u32>(first_texel) / TILE_SIZE;
    let last = vec2<u32>(last_texel) / TILE_SIZE;
    let tiles = min(last - first + 1u, vec2(4u));
    let in_row = (1u << tiles.x) - 1u;
    let rows = 0x1111u & ((1u << (4u * tiles.y)) - 1u);
    let mask = select(WHOLE, rows * in_row, all(last - first < vec2(4u)));
    let corners = first.x | (first.y << 8u) | (last.x << 16u) | (last.y << 24u);
    return vec2(corners, mask | (view_index << 16u));
}

// Tiles of a box that may be within `circle` of `center` [texels], or SCATTERED for the scatter path.
fn tile_rect(
    size: vec2<f32>,
    view_index: u32,
    lo: vec2<f32>,
    hi: vec2<f32>,
    center: vec2<f32>,
    circle: f32,
    may_scatter: bool,
) -> vec2<u32> {
    let rect = box_rect(size, view_index, lo, hi);
    if rect.y == 0u {
        return rect;
    }
    let around = scatter_texel(center);
    let is_tiny = all(ceil(lo - (0.5 + SLACK)) >= around) && all(floor(hi - (0.5 - SLACK)) <= around + 1.0);
    if may_scatter && is_tiny {
        return vec2(SCATTERED, view_index << 16u);
    }
    let first = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
    if any(last - first >= vec2(4u)) {
        return rect;
    }
    var mask = 0u;
    for (var y = first.y; y <= last.y; y += 1u) {
        for (var x = first.x; x <= last.x; x += 1u) {
            let corner = vec2<f32>(vec2(x, y) * TILE_SIZE) + 0.5;
            let outside = center - clamp(center, corner, corner + f32(TILE_SIZE - 1u));
            if dot(outside, outside) <= circle * circle {
                mask |= 1u << ((y - first.y) * 4u + x - first.x);
            }
        }
    }
    if mask == 0u {
        return vec2(0u);
    }
    return vec2(rect.x, mask | (view_index << 16u));
}

// Depth key: quantised monotonically, so that a smaller depth never has a larger key.
fn depth_key(depth: f32) -> u32 {
    return u32(clamp(depth, 0.0, 1.0) * f32(INVISIBLE - 1u));
}

// Depth key by distance, the same on all faces of a cube: 0 at the near plane's centre, 1 at the far
// plane's corner. `distance` from the light [m]. Rust: `GpuView` in src/records/view.rs.
fn distance_key(view: GpuView, distance: f32) -> f32 {
    return (distance - view.near) / distance_span(view);
}

fn distance_span(view: GpuView) -> f32 {
    let corner = view.size * 0.5 / view.scale;
    return view.far * sqrt(1.0 + dot(corner, corner)) - view.near;
}

// Light depth along the ray through `texel` at the distance key `key`.
fn depth_of_key(view: GpuView, texel: vec2<f32>, key: f32) -> f32 {
    if view.perspective == 0.0 {
        return key;
    }
    let slope = (texel - view.size * 0.5) / view.scale;
    let along = (view.near + key * distance_span(view)) / sqrt(1.0 + dot(slope, slope));
    return (along - view.near) / (view.far - view.near);
}
