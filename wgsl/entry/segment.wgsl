// Entry: one segment of a long tile. One workgroup per segment, a column of texels per invocation. An
// accumulator defines what is gathered per texel, an output where it goes: to the tile's sums by atomics,
// because segments of a tile run in parallel, or to the segment's own record. Rust: src/stage/mod.rs.

import package::bind::read::{dispatches, segments};
import package::bind::uniform::views;
import package::records::dispatch::{SEGMENT_DISPATCH, workgroup_number};
import package::records::tile::{Segment, segment_view};
import package::records::view::GpuView;
import package::traversal::lane::tile_texel;
import package::traversal::share::{SHARES, SHARE_LANES, share_texel};
import choice::accumulator::start;
import choice::output::{before_segment, store_segment};
import choice::traversal::walk;

@compute @workgroup_size(SHARE_LANES)
fn walk_segment(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_number(workgroup, workgroups);
    if index >= dispatches[SEGMENT_DISPATCH].w {
        return;
    }
    let segment = segments[index];
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
    before_segment(index);
    start(view, tile_texel(view, segment.tile) + in_tile);
    walk(view, segment.first, segment.end);
    store_segment(segment, index, in_tile);
}
