// bin on GPUs: the lanes of a workgroup share the pairs of its footprints. CPU reference:
// crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bin::bin::emit_outlined;
import package::bin::tiles::raise_dispatch;
import package::bind::changed::{counters, dispatches, overflow, run_offsets};
import package::bind::uniform::{bin_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::batch::{OVERFLOW_DISPATCH, OVERFLOW_SLICES, PART_COUNT_DISPATCH, rect_count};
import package::records::outline::is_outlined;
import package::scan::prefix::SCAN_LANES;
import choice::records::{rect_record, sorted_record};
import choice::scan::prefix_sum;
import choice::writes::write_pair;

// bin, count, on GPUs: number of pairs of each run of the depth-sorted footprints. One workgroup per run;
// each lane takes a footprint at a time. The sums stand in `run_offsets` from index `run_count` on.
@compute @workgroup_size(SCAN_LANES)
fn bin_count_wide(
    @builtin(workgroup_id) run: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let first = run.x * bin_params.run_length;
    let end = min(first + bin_params.run_length, bin_params.footprint_count);
    var pair_count = 0u;
    var visible = 0u;
    for (var i = first + lane; i < end; i += SCAN_LANES) {
        let footprint = sorted_record(i).y;
        let count = rect_count(rect_record(footprint));
        pair_count += count;
        visible += min(count, 1u);
    }
    let total = prefix_sum(lane, pair_count).total;
    if lane == 0u {
        run_offsets[bin_params.run_count + run.x] = total;
    }
    if visible > 0u {
        atomicAdd(&counters.visible, visible);
    }
}

// bin, emit, on GPUs: the pairs of each run, front to back. One workgroup per run: its lanes take a footprint
// each, then all their pairs in turns (load-balancing search: Baxter 2013, "Modern GPU"). No lane waits for a
// large footprint, and neighbouring lanes load and store neighbours. Pairs that do not fit: as in
// bin_emit.wgsl.
@compute @workgroup_size(SCAN_LANES)
fn bin_emit_wide(
    @builtin(workgroup_id) run: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let first = run.x * bin_params.run_length;
    let end = min(first + bin_params.run_length, bin_params.footprint_count);
    var offset = run_offsets[bin_params.run_count + run.x];
    var overflowed = 0u; // running total of all lanes after this one's last addition
    for (var begin = first; begin < end; begin += SCAN_LANES) {
        let i = begin + lane;
        var footprint = 0u;
        var rect = vec2(0u);
        if i < end {
            footprint = sorted_record(i).y;
            rect = rect_record(footprint);
        }
        let count = rect_count(rect);
        let prefix = prefix_sum(lane, count);
        let lane_offset = offset + prefix.before;
        let fits = lane_offset + count <= bin_params.pair_capacity;
        let outlined = HAS_GAUSSIANS && is_outlined(rect);
        take(lane, footprint, rect, prefix.before + count, fits && !outlined);
        if count > 0u && !fits {
            let slot = atomicAdd(&counters.overflowed, 1u);
            overflow[slot] = footprint;
            overflowed = slot + 1u;
            atomicMin(&counters.pair_count, lane_offset);
        }
        workgroupBarrier(); // every lane has its footprint in `taken`
        for (var k = lane; k < prefix.total; k += SCAN_LANES) {
            let owner = lane_of(k);
            let source = taken[owner];
            if source.tiles_x > 0u {
                let before = select(0u, ends[max(owner, 1u) - 1u], owner > 0u);
                write_pair(offset + k, vec2(nth_tile(source, k - before), source.footprint));
            }
        }
        if outlined && fits {
            let view = views[rect.y >> 16u];
            emit_outlined(rect, view.first_tile, view.tiles_x, footprint, lane_offset);
        }
        offset += prefix.total;
    }
    if overflowed > 0u {
        raise_dispatch(PART_COUNT_DISPATCH, (bin_params.footprint_count + 31u) / 32u, 1u);
        raise_dispatch(OVERFLOW_DISPATCH, overflowed, OVERFLOW_SLICES);
        atomicMax(&dispatches[4u * OVERFLOW_DISPATCH + 3u], overflowed);
    }
}

// Tiles of a workgroup's footprints, shared evenly by its lanes, whatever the size of each (load-balancing
// search: Baxter 2013, "Modern GPU"). No lane waits for a large footprint, and neighbours store neighbours.

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
