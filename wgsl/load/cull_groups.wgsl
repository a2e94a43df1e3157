// cull: groups of host casters that each view of a batch may see -> chunks for `project`, view by view, in
// order. One workgroup: every invocation takes consecutive (view, group) combinations. CPU reference: `Frustum`
// in src/shadows/cull/frustum.rs. Rust: src/stage/load.rs.

import package::bind::changed::{chunks, listed, listed_counts};
import package::bind::read::host_groups;
import package::bind::uniform::{cull_params, cull_planes};
import package::records::chunk::Chunk;
import package::records::host::CHUNK_SIZE;

const CULL_LANES: u32 = 256u;
// Rounding of a box as a share of its largest coordinate, and enlargement as a share of its size for axes
// of a view that are not quite unit. Rust: `widened` in src/shadows/cull/frustum.rs.
const BOX_ROUNDING: f32 = 3.8146973e-6;
const BOX_SKEW: f32 = 2e-5;

var<workgroup> sums: array<vec2<u32>, CULL_LANES>;

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

@compute @workgroup_size(CULL_LANES)
fn cull_groups(@builtin(local_invocation_index) lane: u32) {
    let entries = cull_params.view_count * cull_params.group_count;
    let stretch = (entries + CULL_LANES - 1u) / CULL_LANES;
    let first = min(lane * stretch, entries);
    let end = min(first + stretch, entries);
    var sum = vec2(0u); // chunks, footprints
    for (var entry = first; entry < end; entry += 1u) {
        let count = seen_count(entry / cull_params.group_count, entry % cull_params.group_count);
        // Stored, so that the same counts are listed below.
        listed_counts[entry] = count;
        sum += vec2(min(count, 1u), count);
    }
    sums[lane] = sum;
    workgroupBarrier(); // every sum before any is read
    var next = vec2(0u, cull_params.first_footprint);
    for (var before = 0u; before < lane; before += 1u) {
        next += sums[before];
    }
    for (var entry = first; entry < end; entry += 1u) {
        let count = listed_counts[entry];
        let group = cull_params.first_group + entry % cull_params.group_count;
        if count > 0u {
            let caster = cull_params.first_caster + group * CHUNK_SIZE;
            chunks[next.x] = Chunk(entry / cull_params.group_count, caster, count, next.y);
            next += vec2(1u, count);
        }
    }
    if lane == CULL_LANES - 1u {
        listed.chunk_count = next.x;
        listed.footprint_end = next.y;
    }
}
