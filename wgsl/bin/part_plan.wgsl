// bin, where pairs did not fit: number of pairs in all tiles before each tile, in place, and whether the parts
// that are recorded suffice. Else the footprints that did not fit are scattered. One workgroup. Host:
// src/shadows/parts.rs.

import package::bind::changed::{counters, dispatches, tile_pairs};
import package::bind::uniform::{bin_params, part_params};
import package::records::dispatch::{OVERFLOW_DISPATCH, PART_NEXT_DISPATCH};

const LANES: u32 = 256u;
const MANY: u32 = 0x7fffffffu; // pairs past which they are not counted

var<workgroup> sums: array<u32, LANES>;
var<workgroup> most: array<u32, LANES>; // pairs of a tile

fn store_dispatch(place: u32, counts: vec4<u32>) {
    atomicStore(&dispatches[4u * place], counts.x);
    atomicStore(&dispatches[4u * place + 1u], counts.y);
    atomicStore(&dispatches[4u * place + 2u], counts.z);
    atomicStore(&dispatches[4u * place + 3u], counts.w);
}

@compute @workgroup_size(LANES)
fn part_plan(@builtin(local_invocation_index) lane: u32) {
    let stretch = (bin_params.tile_count + LANES - 1u) / LANES;
    let first = min(lane * stretch, bin_params.tile_count);
    let end = min(first + stretch, bin_params.tile_count);
    var sum = 0u;
    var own = 0u;
    for (var tile = first; tile < end; tile += 1u) {
        let count = atomicLoad(&tile_pairs[tile]);
        sum = min(sum + count, MANY);
        own = max(own, count);
    }
    sums[lane] = sum;
    most[lane] = own;
    workgroupBarrier(); // every sum before any is read
    var offset = 0u;
    for (var before = 0u; before < lane; before += 1u) {
        offset = min(offset + sums[before], MANY);
        own = max(own, most[before]);
    }
    for (var tile = first; tile < end; tile += 1u) {
        let count = atomicLoad(&tile_pairs[tile]);
        atomicStore(&tile_pairs[tile], offset);
        offset = min(offset + count, MANY);
    }
    if lane < LANES - 1u {
        return;
    }
    atomicStore(&tile_pairs[bin_params.tile_count], offset);
    // Two parts that follow each other have more pairs than there is room for in one.
    let parts = min(2u * (offset / part_params.room) + 2u, bin_params.tile_count + 1u);
    if offset < MANY && own <= part_params.room && parts <= part_params.most_parts {
        store_dispatch(PART_NEXT_DISPATCH, vec4(1u, 1u, 1u, 1u));
        store_dispatch(OVERFLOW_DISPATCH, vec4(0u));
        atomicStore(&counters.in_parts, atomicLoad(&counters.overflowed));
    }
}
