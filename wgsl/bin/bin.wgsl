// bin: counts the pairs of runs of footprints, and writes them. CPU reference:
// crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bin::tiles::raise_dispatch;
import package::bind::changed::{
    counters, dispatches, overflow, run_offsets, scattered_tiles, segments, tile_cursors,
};
import package::bind::uniform::{bin_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::batch::{
    OVERFLOW_DISPATCH, OVERFLOW_SLICES, PART_COUNT_DISPATCH, RUN_PAIRS, emit_turns, rect_count,
};
import package::records::outline::{is_outlined, load_outline, outline_farthest, outlined_columns};
import package::scan::prefix::{SCAN_LANES, agreed};
import choice::records::{rect_record, sorted_record};
import choice::scan::prefix_sum;
import choice::writes::write_pair;

override WORKGROUP_SIZE: u32; // at least as many as `dispatches` has words

fn clear_counters() {
    atomicStore(&counters.pairs_needed, 0u);
    atomicStore(&counters.pair_count, 0u);
    atomicStore(&counters.visible, 0u);
    atomicStore(&counters.scattered, 0u);
    atomicStore(&counters.overflowed, 0u);
    atomicStore(&counters.segment_count, 0u);
    atomicStore(&counters.merged_count, 0u);
    atomicStore(&counters.disordered, 0u);
    atomicStore(&counters.in_parts, 0u);
    atomicStore(&counters.short_tiles, 0u);
}

// bin, clear: sets the counters, workgroup counts and scattered tiles of a list to zero, before its other
// kernels. One invocation per tile.
@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_clear(@builtin(global_invocation_id) id: vec3<u32>) {
    let tile = id.x;
    if tile < bin_params.tile_count {
        scattered_tiles[tile] = 0u;
    }
    // Only lists with few pairs have cursors.
    if tile < min(bin_params.tile_count, arrayLength(&tile_cursors)) {
        atomicStore(&tile_cursors[tile], 0u);
    }
    if tile < arrayLength(&dispatches) {
        atomicStore(&dispatches[tile], 0u);
    }
    if tile == 0u {
        atomicStore(&segments.count, 0u);
        clear_counters();
    }
}

// bin, count: number of pairs of each run of the depth-sorted footprints. One invocation per run, one
// workgroup per block of runs. `run_offsets` holds for each run the pairs of the earlier runs of its block,
// then the pairs of each block. The sort has put footprints without tiles at the end.
@compute @workgroup_size(SCAN_LANES)
fn bin_count(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let run = block.x * SCAN_LANES + lane;
    let first = min(run, bin_params.run_count) * bin_params.run_length;
    let end = min(first + bin_params.run_length, bin_params.footprint_count);
    var pair_count = 0u;
    var run_turns = 0u;
    var visible = 0u;
    for (var i = first; i < end; i += 1u) {
        let footprint = sorted_record(i).y;
        let rect = rect_record(footprint);
        let count = rect_count(rect);
        let turns = emit_turns(rect, count);
        let counted = run_turns + turns <= RUN_PAIRS;
        visible += min(count, 1u);
        pair_count += select(0u, count, counted);
        run_turns += select(0u, turns, counted);
    }
    let prefix = prefix_sum(lane, pair_count);
    if run < bin_params.run_count {
        run_offsets[run] = prefix.before;
    }
    if lane == 0u {
        run_offsets[bin_params.run_count + block.x] = prefix.total;
    }
    if visible > 0u {
        atomicAdd(&counters.visible, visible);
    }
}

// bin, scan: exclusive prefix sum of the pairs of the blocks of runs, in place. One workgroup.
@compute @workgroup_size(SCAN_LANES)
fn bin_scan(@builtin(local_invocation_index) lane: u32) {
    let runs = max(bin_params.block_runs, 1u);
    let block_count = agreed(lane, (bin_params.run_count + runs - 1u) / runs);
    var total = 0u;
    for (var begin = 0u; begin < block_count; begin += SCAN_LANES) {
        let block = begin + lane;
        let at = bin_params.run_count + block;
        var count = 0u;
        if block < block_count {
            count = run_offsets[at];
        }
        let prefix = prefix_sum(lane, count);
        if block < block_count {
            run_offsets[at] = total + prefix.before;
        }
        total += prefix.total;
    }
    if lane == 0u {
        atomicStore(&counters.pairs_needed, total);
        atomicStore(&counters.pair_count, total);
    }
}

// bin, emit: the pairs of each run, front to back. One invocation per run. A footprint whose pairs do not all
// fit emits none; then the list is walked in parts of its tiles, or the footprint goes to the scatter path.
@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_emit(@builtin(global_invocation_id) id: vec3<u32>) {
    let run = id.x;
    if run >= bin_params.run_count {
        return;
    }
    let first = run * bin_params.run_length;
    let end = min(first + bin_params.run_length, bin_params.footprint_count);
    let block = bin_params.run_count + run / WORKGROUP_SIZE;
    var offset = run_offsets[block] + run_offsets[run];
    var run_turns = 0u;
    var overflowed = 0u; // running total of all runs after this one's last addition
    for (var i = first; i < end; i += 1u) {
        let footprint = sorted_record(i).y;
        let rect = rect_record(footprint);
        var count = rect_count(rect);
        let turns = emit_turns(rect, count);
        let counted = run_turns + turns <= RUN_PAIRS;
        let fits = counted && offset + count <= bin_params.pair_capacity;
        if count > 0u && !fits {
            let slot = atomicAdd(&counters.overflowed, 1u);
            overflow[slot] = footprint;
            overflowed = slot + 1u;
            atomicMin(&counters.pair_count, select(0xffffffffu, offset, counted));
        }
        let view = views[rect.y >> 16u];
        let corner = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
        let last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
        let small = all(last - corner < vec2(4u));
        var mask = rect.y & 0xffffu;
        var next = corner; // tile of a large rectangle
        var emitted = select(0u, count, fits);
        if HAS_GAUSSIANS && emitted > 0u && is_outlined(rect) {
            emit_outlined(rect, view.first_tile, view.tiles_x, footprint, offset);
            emitted = 0u;
        }
        for (var k = 0u; k < emitted; k += 1u) {
            let bit = firstTrailingBit(mask);
            mask &= mask - 1u;
            let at = select(next, corner + vec2(bit & 3u, bit >> 2u), small);
            next = select(vec2(next.x + 1u, next.y), vec2(corner.x, next.y + 1u), next.x == last.x);
            let tile = view.first_tile + at.y * view.tiles_x + at.x;
            write_pair(offset + k, vec2(tile, footprint));
        }
        offset += select(0u, count, counted);
        run_turns += select(0u, turns, counted);
    }
    if overflowed > 0u {
        raise_dispatch(PART_COUNT_DISPATCH, (bin_params.footprint_count + 31u) / 32u, 1u);
        raise_dispatch(OVERFLOW_DISPATCH, overflowed, OVERFLOW_SLICES);
        atomicMax(&dispatches[4u * OVERFLOW_DISPATCH + 3u], overflowed);
    }
}

// Pairs of a Gaussian whose rectangle is large: those of its outline, from pair `first` on.
fn emit_outlined(rect: vec2<u32>, first_tile: u32, tiles_x: u32, footprint: u32, first: u32) {
    let outline = load_outline(footprint);
    let farthest = outline_farthest(outline);
    var pair = first;
    for (var row = (rect.x >> 8u) & 255u; row <= (rect.x >> 24u); row += 1u) {
        let columns = outlined_columns(outline, farthest, row, rect.x);
        for (var x = columns.x; x < columns.y; x += 1u) {
            let tile = first_tile + row * tiles_x + x;
            write_pair(pair, vec2(tile, footprint));
            pair += 1u;
        }
    }
}
