// buckets: pairs of small lists, a bucket for each tile. CPU reference: crates/gobo-reference/src/bin.rs.
// Rust: src/stage/bin.rs.

import package::bin::bin_wide::{ends, lane_of, nth_tile, take, taken};
import package::bin::tiles::record_tile;
import package::bind::changed::{bucketed, counters, tile_cursors};
import package::bind::uniform::{bin_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::batch::{rect_count, workgroup_number};
import package::records::outline::{is_outlined, load_outline, outline_farthest, outlined_columns};
import package::scan::prefix::{SCAN_LANES, agreed};
import choice::bucket::{put_tile, see};
import choice::records::{rect_record, tile_at};
import choice::scan::prefix_sum;
import choice::writes::write_pair;

// The tiles of a Gaussian whose rectangle is large.
fn put_outlined(rect: vec2<u32>, footprint: u32) {
    let view = views[rect.y >> 16u];
    let outline = load_outline(footprint);
    let farthest = outline_farthest(outline);
    for (var row = (rect.x >> 8u) & 255u; row <= (rect.x >> 24u); row += 1u) {
        let columns = outlined_columns(outline, farthest, row, rect.x);
        for (var x = columns.x; x < columns.y; x += 1u) {
            put_tile(view.first_tile + row * view.tiles_x + x, footprint);
        }
    }
}

// bin, buckets: the tiles of each footprint, in any order, first to be counted, then to be written;
// `choice::bucket` says which. One workgroup per 64 footprints, whose tiles its lanes share.
@compute @workgroup_size(SCAN_LANES)
fn bucket_tiles(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let footprint = id.x;
    var rect = vec2(0u);
    if footprint < bin_params.footprint_count {
        rect = rect_record(footprint);
    }
    let count = rect_count(rect);
    see(count);
    let prefix = prefix_sum(lane, count);
    let outlined = HAS_GAUSSIANS && is_outlined(rect);
    take(lane, footprint, rect, prefix.before + count, !outlined);
    workgroupBarrier(); // all have taken one
    for (var k = lane; k < prefix.total; k += SCAN_LANES) {
        let owner = lane_of(k);
        let source = taken[owner];
        if source.tiles_x > 0u {
            let before = select(0u, ends[max(owner, 1u) - 1u], owner > 0u);
            put_tile(nth_tile(source, k - before), source.footprint);
        }
    }
    if outlined {
        put_outlined(rect, footprint);
    }
}

var<workgroup> start: u32; // of the workgroup's pairs

// bin, buckets: room for the pairs of each tile, and its record; cuts long tiles into segments. One
// invocation per tile. Which of two workgroups is first decides where a tile's pairs are, and nothing else.
@compute @workgroup_size(SCAN_LANES)
fn bucket_place(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = id.x;
    var count = 0u;
    if tile < bin_params.tile_count {
        count = atomicLoad(&tile_cursors[tile]);
    }
    let prefix = prefix_sum(lane, count);
    if lane == 0u {
        start = atomicAdd(&counters.pair_count, prefix.total);
        atomicAdd(&counters.pairs_needed, prefix.total);
    }
    let first = workgroupUniformLoad(&start) + prefix.before;
    if tile < bin_params.tile_count {
        atomicStore(&tile_cursors[tile], first);
        record_tile(tile, tile, vec2(first, first + count), true);
    }
}

const LANES: u32 = 128u;
const CHUNK: u32 = 1024u; // pairs: 8 KiB
const BEHIND_ALL: vec2<u32> = vec2(0xffffffffu);

var<workgroup> held: array<vec2<u32>, CHUNK>;

fn is_before(a: vec2<u32>, b: vec2<u32>) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}

// Sorts the pairs from `first` on, at most CHUNK.
fn sort_chunk(lane: u32, first: u32, count: u32) {
    let size = 1u << (32u - countLeadingZeros(count - 1u));
    for (var i = lane; i < size; i += LANES) {
        var pair = BEHIND_ALL;
        if i < count {
            pair = bucketed[first + i];
        }
        held[i] = pair;
    }
    workgroupBarrier(); // all are loaded
    for (var run = 2u; run <= size; run *= 2u) {
        for (var apart = run / 2u; apart > 0u; apart /= 2u) {
            for (var i = lane; i < size / 2u; i += LANES) {
                let low = 2u * i - (i & (apart - 1u));
                let a = held[low];
                let b = held[low + apart];
                let rises = (low & run) == 0u;
                if is_before(b, a) == rises {
                    held[low] = b;
                    held[low + apart] = a;
                }
            }
            workgroupBarrier(); // all of a step are exchanged
        }
    }
}

// Pairs of a sorted run that are before `pair`, by bisection.
fn rank_in(first: u32, count: u32, pair: vec2<u32>) -> u32 {
    var low = 0u;
    var high = count;
    while low < high {
        let middle = (low + high) / 2u;
        let before = is_before(bucketed[first + middle], pair);
        low = select(low, middle + 1u, before);
        high = select(middle, high, before);
    }
    return low;
}

// bin, buckets: the pairs of each tile, front to back, by depth key and then by footprint, which is the order
// of the stable sorts. One workgroup per tile. Up to CHUNK pairs are sorted in workgroup memory (bitonic:
// Batcher 1968); chunks of more are merged, two by two, from one half of `bucketed` to the other.
@compute @workgroup_size(LANES)
fn bucket_sort(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let tile = workgroup_number(workgroup, workgroups);
    let record = tile_at(tile);
    let first = agreed(lane, record.first);
    let count = agreed(lane, record.end) - first;
    for (var begin = 0u; begin < count; begin += CHUNK) {
        let of_chunk = min(count - begin, CHUNK);
        sort_chunk(lane, first + begin, of_chunk);
        for (var i = lane; i < of_chunk; i += LANES) {
            if count <= CHUNK {
                write_pair(first + i, vec2(tile, held[i].y));
            } else {
                bucketed[first + begin + i] = held[i];
            }
        }
        workgroupBarrier(); // all are read before others are loaded
    }
    var sorted_at = first;
    var merged_at = first + arrayLength(&bucketed) / 2u;
    for (var run = CHUNK; run < count; run *= 2u) {
        storageBarrier(); // the runs are sorted
        let is_last = 2u * run >= count;
        for (var i = lane; i < count; i += LANES) {
            let pair = bucketed[sorted_at + i];
            let own = i / run * run;
            let other = own ^ run;
            var rank = 0u;
            if other < count {
                rank = rank_in(sorted_at + other, min(run, count - other), pair);
            }
            let slot = min(own, other) + i - own + rank;
            if is_last {
                write_pair(first + slot, vec2(tile, pair.y));
            } else {
                bucketed[merged_at + slot] = pair;
            }
        }
        let merged = merged_at;
        merged_at = sorted_at;
        sorted_at = merged;
    }
}
