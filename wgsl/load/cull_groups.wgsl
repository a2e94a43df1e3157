// cull, groups: casters of each group of host casters that a view of a batch may see. One invocation per
// (view, group) combination, one workgroup per block of them. `listed_counts` holds the casters of each
// combination, then the chunks of each block, then the casters of each block. CPU reference: `Frustum` in
// src/shadows/cull/frustum.rs. Rust: src/stage/load.rs.

import package::bind::changed::listed_counts;
import package::bind::read::host_groups;
import package::bind::uniform::{cull_params, cull_planes};
import package::load::cull::{both_counts, chunks_of, cull_blocks, cull_entries, footprints_of};
import package::scan::prefix::SCAN_LANES;
import choice::scan::prefix_sum;

// Rounding of a box, as a share of its largest coordinate, and growth, as a share of its size, for view axes
// that are not exactly unit. Rust: `widened` in src/shadows/cull/frustum.rs.
const BOX_ROUNDING: f32 = 3.8146973e-6;
const BOX_SKEW: f32 = 2e-5;

// Number of casters of the group, or 0 if its box is outside a plane of the view.
fn seen_count(view: u32, group: u32) -> u32 {
    let box = host_groups[cull_params.first_group + group];
    let largest = max(abs(box.low), abs(box.high));
    let pad = max(largest.x, max(largest.y, largest.z)) * BOX_ROUNDING + 1e-30;
    let center = (box.low + box.high) * 0.5;
    let half = (box.high - box.low) * (0.5 + BOX_SKEW) + pad;
    var count = box.count;
    for (var i = 0u; i < 6u; i += 1u) {
        let plane = cull_planes[6u * view + i];
        let nearest = dot(plane.xyz, center) + plane.w + dot(abs(plane.xyz), half);
        count = select(count, 0u, nearest < 0.0);
    }
    return count;
}

@compute @workgroup_size(SCAN_LANES)
fn cull_groups(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let entry = block.x * SCAN_LANES + lane;
    let entries = cull_entries();
    var count = 0u;
    if entry < entries {
        count = seen_count(entry / cull_params.group_count, entry % cull_params.group_count);
        listed_counts[entry] = count;
    }
    let total = prefix_sum(lane, both_counts(count)).total;
    if lane == 0u {
        let at = entries + block.x;
        listed_counts[at] = chunks_of(total);
        listed_counts[at + cull_blocks()] = footprints_of(total);
    }
}
