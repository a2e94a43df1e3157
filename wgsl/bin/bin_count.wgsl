// bin, count: number of pairs of each run of the depth-sorted footprints. One invocation per run. The sort
// has put footprints without tiles at the end. CPU reference: src/reference/bin.rs. Rust: src/stage/bin.rs.

import package::bind::changed::{counters, run_offsets};
import package::bind::loaded::{rects, sorted};
import package::bind::uniform::bin_params;
import package::records::bin::{RUN_PAIRS, emit_turns, rect_count};
import package::records::record::record_texel;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn bin_count(@builtin(global_invocation_id) id: vec3<u32>) {
    let run = id.x;
    if run >= bin_params.run_count {
        return;
    }
    let first = run * bin_params.run_length;
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
    run_offsets[run] = pairs;
    atomicAdd(&counters.visible, visible);
}
