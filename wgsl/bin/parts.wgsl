// bin, where pairs may not fit: parts of the tiles. Rust: src/shadows/batch/parts.rs.

import package::bin::tiles::record_tile;
import package::bind::changed::{counters, dispatches, part_turn, segments, tile_pairs};
import package::bind::uniform::{bin_params, part_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::batch::{
    MERGED_DISPATCH, OVERFLOW_DISPATCH, PARTED_DISPATCH, PART_DISPATCH, SEGMENT_DISPATCH, covers, rect_count,
    workgroup_number,
};
import package::records::outline::{Outline, is_outlined, is_within, load_outline};
import choice::records::{rect_record, sorted_record};
import choice::writes::write_key;

// Bands: runs of a batch's tiles. Each band has a row of bits, one per footprint in depth order, set if the
// footprint may touch the band. 32 footprints have 32 texels of `keys`, with the words of two bands in each.

const BANDS: u32 = 64u;

fn band_of(tile: u32) -> u32 {
    return tile * BANDS / max(bin_params.tile_count, 1u);
}

override WORKGROUP_SIZE: u32;

// bin, where pairs may not fit: sets the pair count of every tile to zero. One invocation per tile.
@compute @workgroup_size(WORKGROUP_SIZE)
fn part_clear(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < bin_params.tile_count {
        atomicStore(&tile_pairs[id.x], 0u);
    }
}

const LANES: u32 = 32u;

fn footprint_of(index: u32) -> u32 {
    return sorted_record(min(index, bin_params.footprint_count - 1u)).y;
}

fn rect_of(index: u32) -> vec2<u32> {
    let rect = rect_record(footprint_of(index));
    return select(vec2(0u), rect, index < bin_params.footprint_count);
}

fn add_tile(rect: vec2<u32>, outline: Outline, corner: vec2<u32>, width: u32, height: u32, k: u32) {
    let view = rect.y >> 16u;
    let tile = corner + vec2(k % width, k / width);
    let is_outside = HAS_GAUSSIANS && is_outlined(rect) && !is_within(outline, rect, tile);
    if k < width * height && covers(rect, view, tile) && !is_outside {
        atomicAdd(&tile_pairs[views[view].first_tile + tile.y * views[view].tiles_x + tile.x], 1u);
    }
}

// First and last band that the rectangle may touch; none if the first is larger.
fn bands_of(rect: vec2<u32>) -> vec2<u32> {
    let view = views[rect.y >> 16u];
    let first = view.first_tile + ((rect.x >> 8u) & 255u) * view.tiles_x + (rect.x & 255u);
    let last = view.first_tile + (rect.x >> 24u) * view.tiles_x + ((rect.x >> 16u) & 255u);
    return select(vec2(BANDS, 0u), vec2(band_of(first), band_of(last)), rect_count(rect) > 0u);
}

// bin, where pairs did not fit: number of pairs of every tile of the batch, and the bands of tiles that each
// footprint may touch. One workgroup per 32 footprints in depth order.
@compute @workgroup_size(LANES)
fn part_count(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let first = workgroup_number(workgroup, workgroups) * LANES;
    if first >= bin_params.footprint_count {
        return;
    }
    let lane_rect = rect_of(first + lane);
    let corner = vec2(lane_rect.x & 255u, (lane_rect.x >> 8u) & 255u);
    let width = ((lane_rect.x >> 16u) & 255u) - corner.x + 1u;
    let height = select(0u, (lane_rect.x >> 24u) - corner.y + 1u, rect_count(lane_rect) > 0u);
    var outline: Outline;
    if HAS_GAUSSIANS && is_outlined(lane_rect) {
        outline = load_outline(footprint_of(first + lane));
    }
    // Two tiles a turn: a map has more tiles than the turns that llvmpipe allows an invocation.
    for (var k = 0u; k < width * height; k += 2u) {
        add_tile(lane_rect, outline, corner, width, height, k);
        add_tile(lane_rect, outline, corner, width, height, k + 1u);
    }
    var words = vec2(0u);
    for (var i = 0u; i < LANES; i += 1u) {
        let bands = bands_of(rect_of(first + i));
        let even = bands.x <= 2u * lane && 2u * lane <= bands.y;
        let odd = bands.x <= 2u * lane + 1u && 2u * lane + 1u <= bands.y;
        words |= select(vec2(0u), vec2(1u << i), vec2(even, odd));
    }
    write_key(first + lane, words);
}

const PLAN_LANES: u32 = 256u;
const MANY: u32 = 0x7fffffffu; // bound of the count of pairs

var<workgroup> sums: array<u32, PLAN_LANES>;
var<workgroup> most: array<u32, PLAN_LANES>; // pairs of a tile

fn store_dispatch(dispatch: u32, counts: vec4<u32>) {
    atomicStore(&dispatches[4u * dispatch], counts.x);
    atomicStore(&dispatches[4u * dispatch + 1u], counts.y);
    atomicStore(&dispatches[4u * dispatch + 2u], counts.z);
    atomicStore(&dispatches[4u * dispatch + 3u], counts.w);
}

fn clear_segments() {
    atomicStore(&segments.count, 0u);
    for (var i = 0u; i < 3u; i += 1u) {
        atomicStore(&dispatches[4u * SEGMENT_DISPATCH + i], 0u);
    }
}

// bin, where pairs did not fit: exclusive prefix sum of the tiles' pairs, in place, and whether the recorded
// parts suffice. Else the footprints that did not fit are scattered. One workgroup.
@compute @workgroup_size(PLAN_LANES)
fn part_plan(@builtin(local_invocation_index) lane: u32) {
    let overflowed = atomicLoad(&counters.overflowed);
    let count = select(0u, bin_params.tile_count, overflowed > 0u);
    let stretch = (count + PLAN_LANES - 1u) / PLAN_LANES;
    let first = min(lane * stretch, count);
    let end = min(first + stretch, count);
    var sum = 0u;
    var largest = 0u;
    for (var tile = first; tile < end; tile += 1u) {
        let pairs = atomicLoad(&tile_pairs[tile]);
        sum = min(sum + pairs, MANY);
        largest = max(largest, pairs);
    }
    sums[lane] = sum;
    most[lane] = largest;
    workgroupBarrier(); // every sum before any is read
    var offset = 0u;
    for (var before = 0u; before < lane; before += 1u) {
        offset = min(offset + sums[before], MANY);
        largest = max(largest, most[before]);
    }
    for (var tile = first; tile < end; tile += 1u) {
        let pairs = atomicLoad(&tile_pairs[tile]);
        atomicStore(&tile_pairs[tile], offset);
        offset = min(offset + pairs, MANY);
    }
    if lane < PLAN_LANES - 1u {
        return;
    }
    atomicStore(&tile_pairs[count], offset);
    // Two consecutive parts together have more pairs than one has room for.
    let parts = min(2u * (offset / part_params.room) + 2u, bin_params.tile_count + 1u);
    let enough = offset < MANY && largest <= part_params.room && parts <= part_params.most_parts;
    part_turn = vec4(0u);
    if overflowed > 0u && enough {
        part_turn = vec4(1u);
        store_dispatch(PARTED_DISPATCH, vec4(1u, 0u, 0u, 0u));
        store_dispatch(OVERFLOW_DISPATCH, vec4(0u));
        atomicStore(&counters.in_parts, overflowed);
    }
}

// bin, before the parts of the tiles: sets the numbers of segments to zero, so that no segment is walked
// again where no part follows. One invocation.
@compute @workgroup_size(1)
fn part_first() {
    clear_segments();
    store_dispatch(MERGED_DISPATCH, vec4(0u));
}

const MAX_WORKGROUPS: u32 = 65535u; // workgroups in a row on every adapter
const TILE_LANES: u32 = 64u;

// bin, where pairs did not fit: the next part of the tiles, as many as there is room for their pairs, and the
// first and last pair of each. One workgroup.
@compute @workgroup_size(TILE_LANES)
fn part_next(@builtin(local_invocation_index) lane: u32) {
    let first = atomicLoad(&dispatches[4u * PARTED_DISPATCH + 3u]);
    let before = atomicLoad(&tile_pairs[first]);
    var end = first;
    var limit = min(bin_params.tile_count, first + MAX_WORKGROUPS);
    while end < limit {
        let middle = (end + limit + 1u) / 2u;
        let fits = atomicLoad(&tile_pairs[middle]) - before <= part_params.room;
        end = select(end, middle, fits);
        limit = select(middle - 1u, limit, fits);
    }
    storageBarrier(); // every lane has read where the part begins
    if lane == 0u {
        store_dispatch(PART_DISPATCH, vec4(end - first, 1u, 1u, first));
        store_dispatch(PARTED_DISPATCH, vec4(1u, 0u, 0u, end));
        clear_segments();
        store_dispatch(MERGED_DISPATCH, vec4(0u));
    }
    storageBarrier(); // segments are counted from zero
    for (var tile = first + lane; tile < end; tile += TILE_LANES) {
        let range = vec2(atomicLoad(&tile_pairs[tile]), atomicLoad(&tile_pairs[tile + 1u]));
        record_tile(tile, tile - first, range - before, true);
    }
}
