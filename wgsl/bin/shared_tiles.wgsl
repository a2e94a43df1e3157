// Tiles of a workgroup's footprints, shared evenly by its lanes, whatever the size of each (load-balancing
// search: Baxter 2013, "Modern GPU"). No lane waits for a large footprint, and neighbours store neighbours.

import package::bind::uniform::views;
import package::scan::prefix::SCAN_LANES;

// A lane's footprint.
struct Taken {
    footprint: u32,
    tile: u32,    // of its rectangle's corner
    tiles_x: u32, // of its view; 0: none of its tiles is shared
    mask: u32,    // of a small rectangle's tiles
    width: u32,   // of a large rectangle [tiles]; 0 of a small one
}

var<workgroup> taken: array<Taken, SCAN_LANES>;
var<workgroup> ends: array<u32, SCAN_LANES>; // pairs of the lanes up to each

// `lane`, or the one `step` further if the lanes in between end at or before pair `k`.
fn further(lane: u32, step: u32, k: u32) -> u32 {
    return lane + select(0u, step, ends[lane + step - 1u] <= k);
}

// A lane's footprint, whose tiles end at `last` among those of all. `is_shared`: whether the others take some
// of them.
fn take(lane: u32, footprint: u32, rect: vec2<u32>, last: u32, is_shared: bool) {
    let view = views[rect.y >> 16u];
    let corner = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let size = vec2((rect.x >> 16u) & 255u, rect.x >> 24u) - corner + 1u;
    let tile = view.first_tile + corner.y * view.tiles_x + corner.x;
    let width = select(size.x, 0u, all(size <= vec2(4u)));
    let tiles_x = select(0u, view.tiles_x, is_shared);
    taken[lane] = Taken(footprint, tile, tiles_x, rect.y & 0xffffu, width);
    ends[lane] = last;
}

// The lane that has pair `k` of them all: the first that ends behind it. By bisection, without a loop, which
// costs more.
fn lane_of(k: u32) -> u32 {
    let lane = further(further(further(0u, 32u, k), 16u, k), 8u, k);
    return further(further(further(lane, 4u, k), 2u, k), 1u, k);
}

// Place of a bit, and the set ones left to pass: `bits` further if fewer are set in between.
fn passed(at: vec2<u32>, mask: u32, bits: u32) -> vec2<u32> {
    let ones = countOneBits(extractBits(mask, at.x, bits));
    return select(at, vec2(at.x + bits, at.y - ones), ones <= at.y);
}

// Tile `n` of a footprint's.
fn nth_tile(source: Taken, n: u32) -> u32 {
    if source.width > 0u {
        return source.tile + n / source.width * source.tiles_x + n % source.width;
    }
    let mask = source.mask;
    let bit = passed(passed(passed(passed(vec2(0u, n), mask, 8u), mask, 4u), mask, 2u), mask, 1u).x;
    return source.tile + (bit >> 2u) * source.tiles_x + (bit & 3u);
}
