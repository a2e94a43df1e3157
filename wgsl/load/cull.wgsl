// cull: the groups of host casters that each view may see. CPU reference: `Frustum` in
// src/shadows/cull/frustum.rs. Rust: src/stage/load.rs.

import package::bind::changed::{chunks, listed_bin_params, listed_counts, listed_project_params};
import package::bind::read::host_groups;
import package::bind::uniform::{cull_params, cull_planes};
import package::records::batch::Chunk;
import package::records::host::CHUNK_SIZE;
import package::scan::prefix::{SCAN_LANES, agreed};
import choice::scan::prefix_sum;

// Counts that the steps of `cull` share.

const CULL_BLOCK: u32 = 128u; // (view, group) combinations per workgroup
const CHUNKS_SHIFT: u32 = 20u;

fn cull_entries() -> u32 {
    return cull_params.view_count * cull_params.group_count;
}

fn cull_blocks() -> u32 {
    return (cull_entries() + CULL_BLOCK - 1u) / CULL_BLOCK;
}

// Chunks and footprints of a combination, in one word: a block has fewer than 2^20 footprints.
fn both_counts(count: u32) -> u32 {
    return (min(count, 1u) << CHUNKS_SHIFT) | count;
}

fn chunks_of(counts: u32) -> u32 {
    return counts >> CHUNKS_SHIFT;
}

fn footprints_of(counts: u32) -> u32 {
    return counts & ((1u << CHUNKS_SHIFT) - 1u);
}

// Rounding of a box, as a share of its largest coordinate, and growth, as a share of its size, for view axes
// that are not exactly unit. Rust: `widened` in src/shadows/cull/frustum.rs.
const BOX_ROUNDING: f32 = 3.8146973e-6;
const BOX_SKEW: f32 = 2e-5;

// Number of casters of the group, or 0 if its box is outside a plane of the view.
fn seen_count(view: u32, group: u32) -> u32 {
    let box = host_groups[1u + cull_params.first_group + group];
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

// cull, groups: casters of each group of host casters that a view of a batch may see. One invocation per
// (view, group) combination, one workgroup per block of them. `listed_counts` holds the casters of each
// combination, then the chunks of each block, then the casters of each block.
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

// Replaces the counts of blocks, from `first` on, by their exclusive prefix sum from `start`; returns the
// total.
fn scan_blocks(lane: u32, first: u32, start: u32) -> u32 {
    let block_count = agreed(lane, cull_blocks());
    var total = start;
    for (var begin = 0u; begin < block_count; begin += SCAN_LANES) {
        let block = begin + lane;
        var count = 0u;
        if block < block_count {
            count = listed_counts[first + block];
        }
        let prefix = prefix_sum(lane, count);
        if block < block_count {
            listed_counts[first + block] = total + prefix.before;
        }
        total += prefix.total;
    }
    return total;
}

// cull, scan: exclusive prefix sums of the blocks' chunks and footprints, in place, and their totals for the
// list. One workgroup.
@compute @workgroup_size(SCAN_LANES)
fn cull_scan(@builtin(local_invocation_index) lane: u32) {
    let first = cull_entries();
    let chunk_count = scan_blocks(lane, first, 0u);
    let footprint_end = scan_blocks(lane, first + cull_blocks(), cull_params.first_footprint);
    if lane == 0u {
        listed_project_params.chunk_count = chunk_count;
        listed_bin_params.footprint_count = footprint_end;
    }
}

// cull, list: chunks for `project`, view by view, in order. One invocation per (view, group) combination.
@compute @workgroup_size(SCAN_LANES)
fn cull_list(
    @builtin(workgroup_id) block: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let entry = block.x * SCAN_LANES + lane;
    let entries = cull_entries();
    var count = 0u;
    if entry < entries {
        count = listed_counts[entry];
    }
    let before = prefix_sum(lane, both_counts(count)).before;
    if count > 0u {
        let at = entries + block.x;
        let chunk = listed_counts[at] + chunks_of(before);
        let first_footprint = listed_counts[at + cull_blocks()] + footprints_of(before);
        let group = cull_params.first_group + entry % cull_params.group_count;
        let caster = cull_params.first_caster + group * CHUNK_SIZE;
        chunks[chunk] = Chunk(entry / cull_params.group_count, caster, count, first_footprint);
    }
}
