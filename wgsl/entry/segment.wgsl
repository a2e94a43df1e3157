// Entry: one segment of a long tile. One workgroup per segment, a column of texels per invocation. A state
// defines what is gathered per texel, a store where it goes: to the tile's sums by atomics, because
// segments of a tile run in parallel, or to the segment's own record. Rust: src/stage/mod.rs.

import package::bind::read::{dispatches, segments};
import package::bind::uniform::views;
import package::records::dispatch::{SEGMENT_DISPATCH, workgroup_number};
import package::records::tile::segment_view;
import package::traversal::lane::{LANES, lane_texel, tile_texel};
import choice::accumulator::start;
import choice::output::store_segment;
import choice::traversal::walk;

@compute @workgroup_size(LANES)
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
    let place = lane_texel(lane);
    start(view, tile_texel(view, segment.tile) + place);
    walk(view, segment.first, segment.end);
    store_segment(segment, index, place);
}
