// Entry: one segment of a long tile with order-dependent blending. Like wgsl/entry/walk.wgsl, but each hit
// belongs to the last segment whose front it lies behind: a segment also visits the last pairs of the
// previous one, and leaves hits behind the next front to the next. CPU reference:
// crates/gobo-reference/src/accumulate.rs, which sorts all hits of a ray.

import package::accumulator::filter::{ROWS, body_faces, start, texels};
import package::bind::read::segments;
import package::bind::uniform::views;
import package::entry::walk::{SHARES, SHARE_LANES, share_texel};
import package::features::{HAS_OVER, unrolled};
import package::hit::hit_order::least_depth;
import package::records::batch::workgroup_number;
import package::records::footprint::{front_depth, load_footprint};
import package::records::tile::{Segment, is_first_segment, is_last_segment, segment_view};
import package::records::view::GpuView;
import package::traversal::lane::tile_texel;
import choice::output::store_segment;
import choice::records::pair_record;
import choice::traversal::walk;

// Pairs at the end of a segment whose hits belong to the next segment if they lie behind its front.
const OVERLAP: u32 = 256u;

fn pair_front(pair: u32) -> f32 {
    return front_depth(load_footprint(pair_record(pair).y));
}

@compute @workgroup_size(SHARE_LANES)
fn walk_ordered_segment(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_number(workgroup, workgroups);
    if index >= segments.count {
        return;
    }
    let segment = segments.all[index];
    let view = views[segment_view(segment)];
    if SHARES == 1u {
        walk_share(view, segment, index, share_texel(0u, lane));
        return;
    }
    for (var share = workgroup.z; share < SHARES; share += workgroups.z) {
        walk_share(view, segment, index, share_texel(share, lane));
    }
}

// `in_tile`: the invocation's first texel.
fn walk_share(view: GpuView, segment: Segment, index: u32, in_tile: vec2<u32>) {
    start(view, tile_texel(view, segment.tile) + in_tile);
    // Parts: the last pairs of the previous segment, this segment's own pairs, and its last pairs.
    let is_last = is_last_segment(segment);
    let overlapped = select(segment.first - OVERLAP, segment.first, is_first_segment(segment));
    let last = select(segment.end - OVERLAP, segment.end, is_last);
    for (var part = select(1u, 0u, HAS_OVER); part < select(2u, 3u, HAS_OVER); part += 1u) {
        var first = segment.first;
        var end = segment.end;
        if HAS_OVER {
            first = select(select(overlapped, first, part == 1u), last, part == 2u);
            end = select(select(end, last, part == 1u), segment.first, part == 0u);
            // Without a next segment, the last part has no pairs.
            let front = pair_front(min(end, segment.end - u32(is_last)));
            for (var i = 0u; i < unrolled(ROWS); i += 1u) {
                let depth = least_depth(texels[i].keys, front);
                texels[i].begin = select(-1.0, depth, part == 0u);
                texels[i].before = select(2.0, depth, part == 2u);
            }
            body_faces = part > 0u;
        }
        walk(view, first, end);
    }
    store_segment(segment, index, in_tile);
}
