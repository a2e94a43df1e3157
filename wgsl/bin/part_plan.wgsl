// bin, where pairs did not fit: exclusive prefix sum of the tiles' pairs, in place, and whether the recorded
// parts suffice. Else the footprints that did not fit are scattered. One workgroup. Rust:
// src/shadows/batch/parts.rs.

import package::bind::changed::{counters, dispatches, part_turn, tile_pairs};
import package::bind::uniform::{bin_params, part_params};
import package::records::dispatch::{OVERFLOW_DISPATCH, PARTED_DISPATCH};

const LANES: u32 = 256u;
const MANY: u32 = 0x7fffffffu; // bound of the count of pairs

var<workgroup> sums: array<u32, LANES>;
var<workgroup> most: array<u32, LANES>; // pairs of a tile

fn store_dispatch(dispatch: u32, counts: vec4<u32>) {
    atomicStore(&dispatches[4u * dispatch], counts.x);
    atomicStore(&dispatches[4u * dispatch + 1u], counts.y);
    atomicStore(&dispatches[4u * dispatch + 2u], counts.z);
    atomicStore(&dispatches[4u * dispatch + 3u], counts.w);
}

@compute @workgroup_size(LANES)
fn part_plan(@builtin(local_invocation_index) lane: u32) {
    let overflowed = atomicLoad(&counters.overflowed);
    let count = select(0u, bin_params.tile_count, overflowed > 0u);
    let stretch = (count + LANES - 1u) / LANES;
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
    if lane < LANES - 1u {
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
