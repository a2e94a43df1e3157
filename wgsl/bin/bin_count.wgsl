// bin, count: number of pairs of each run of the depth-sorted footprints. One invocation per run, one
// workgroup per block of runs. `run_offsets` holds for each run the pairs of the earlier runs of its block,
// then the pairs of each block. The sort has put footprints without tiles at the end. CPU reference:
// crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bind::changed::{counters, run_offsets};
import package::bind::loaded::{rects, sorted};
import package::bind::uniform::bin_params;
import package::records::bin::{RUN_PAIRS, emit_turns, rect_count};
import package::records::record::record_texel;
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

@compute @workgroup_size(SCAN_LANES)
fn bin_count(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let run = block.x * SCAN_LANES + lane;
    let first = min(run, bin_params.run_count) * bin_params.run_length;
    let end = min(first + bin_params.run_length, bin_params.footprint_count);
    var pairs = 0u;
    var run_turns = 0u;
    var visible = 0u;
    for (var i = first; i < end; i += 1u) {
        let footprint = textureLoad(sorted, record_texel(i)).g;
        let rect = textureLoad(rects, record_texel(footprint)).rg;
        let count = rect_count(rect);
        let turns = emit_turns(rect, count);
        let counted = run_turns + turns <= RUN_PAIRS;
        visible += min(count, 1u);
        pairs += select(0u, count, counted);
        run_turns += select(0u, turns, counted);
    }
    let prefix = prefix_sum(lane, pairs);
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
