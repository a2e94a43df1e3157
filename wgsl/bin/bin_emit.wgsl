// bin, emit: the pairs of each run, front to back. One invocation per run. A footprint whose pairs do not all
// fit emits none; then the list is walked in parts of its tiles, or the footprint goes to the scatter path.
// CPU reference: crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bin::emit_outlined::emit_outlined;
import package::bin::raise_dispatch::raise_dispatch;
import package::bind::changed::{counters, overflow, run_offsets};
import package::bind::loaded::{rects, sorted};
import package::bind::stored::pairs;
import package::bind::uniform::{bin_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::bin::{RUN_PAIRS, emit_turns, rect_count};
import package::records::dispatch::{
    OVERFLOW_DISPATCH, OVERFLOW_SLICES, PART_COUNT_DISPATCH,
};
import package::records::outline::is_outlined;
import package::records::record::record_texel;

override WORKGROUP_SIZE: u32;

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
        let footprint = textureLoad(sorted, record_texel(i)).g;
        let rect = textureLoad(rects, record_texel(footprint)).rg;
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
            textureStore(pairs, record_texel(offset + k), vec4(tile, footprint, 0u, 0u));
        }
        offset += select(0u, count, counted);
        run_turns += select(0u, turns, counted);
    }
    if overflowed > 0u {
        raise_dispatch(PART_COUNT_DISPATCH, (bin_params.footprint_count + 31u) / 32u, 1u);
        raise_dispatch(OVERFLOW_DISPATCH, overflowed, OVERFLOW_SLICES);
    }
}
