// bin, count, on GPUs: number of pairs of each run of the depth-sorted footprints. One workgroup per run;
// each lane takes a footprint at a time. The sums stand in `run_offsets` from index `run_count` on. CPU
// reference: crates/gobo-reference/src/bin.rs. Rust: src/stage/bin.rs.

import package::bind::changed::{counters, run_offsets};
import package::bind::loaded::{rects, sorted};
import package::bind::uniform::bin_params;
import package::records::bin::rect_count;
import package::records::record::record_texel;
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

@compute @workgroup_size(SCAN_LANES)
fn bin_count_wide(
    @builtin(workgroup_id) run: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let first = run.x * bin_params.run_length;
    let end = min(first + bin_params.run_length, bin_params.footprint_count);
    var pairs = 0u;
    var visible = 0u;
    for (var i = first + lane; i < end; i += SCAN_LANES) {
        let footprint = textureLoad(sorted, record_texel(i)).g;
        let count = rect_count(textureLoad(rects, record_texel(footprint)).rg);
        pairs += count;
        visible += min(count, 1u);
    }
    let total = prefix_sum(lane, pairs).total;
    if lane == 0u {
        run_offsets[bin_params.run_count + run.x] = total;
    }
    if visible > 0u {
        atomicAdd(&counters.visible, visible);
    }
}
