// bin, emit, on GPUs: the pairs of each run, front to back. One workgroup per run: its lanes take a footprint
// each, then all their pairs in turns (load-balancing search: Baxter 2013, "Modern GPU"). No lane waits for a
// large footprint, and neighbouring lanes load and store neighbours. Pairs that do not fit: as in
// bin_emit.wgsl. CPU reference: crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bin::emit_outlined::emit_outlined;
import package::bin::raise_dispatch::raise_dispatch;
import package::bin::shared_tiles::{ends, lane_of, nth_tile, take, taken};
import package::bind::changed::{counters, overflow, run_offsets};
import package::bind::loaded::{rects, sorted};
import package::bind::stored::pairs;
import package::bind::uniform::{bin_params, views};
import package::features::HAS_GAUSSIANS;
import package::records::bin::rect_count;
import package::records::dispatch::{OVERFLOW_DISPATCH, OVERFLOW_SLICES, PART_COUNT_DISPATCH};
import package::records::outline::is_outlined;
import package::records::record::record_texel;
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

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
            footprint = textureLoad(sorted, record_texel(i)).g;
            rect = textureLoad(rects, record_texel(footprint)).rg;
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
                let pair = vec4(nth_tile(source, k - before), source.footprint, 0u, 0u);
                textureStore(pairs, record_texel(offset + k), pair);
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
    }
}
