// colored, segments: adds one segment of a long tile to the nearest opaque depths by channel. One
// workgroup per segment, four texels per invocation; atomics, because segments of a tile run side
// by side. CPU twin: src/reference/colored.rs. Host: src/stage/colored.rs.

import package::bind::read::{dispatches, segments};
import package::bind::uniform::views;
import package::hit::blocks_colored::nearnesses;
import package::records::dispatch::SEGMENT_DISPATCH;
import package::state::colored::{nearest, start};
import package::walk::lane::{LANES, lane_texel, sum_index, tile_texel};
import choice::sums::raise_channels;
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn colored_segments(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup.y * workgroups.x + workgroup.x;
    if index >= dispatches[SEGMENT_DISPATCH].w {
        return;
    }
    let segment = segments[index];
    let view = views[segment.view];
    let place = lane_texel(lane);
    start(view, tile_texel(view, segment.tile) + place);
    walk(view, segment.first, segment.end);
    for (var i = 0u; i < 4u; i += 1u) {
        if any(nearest[i] < vec3(1.0)) {
            raise_channels(sum_index(segment.tile, place + vec2(0u, i)), nearnesses(nearest[i]));
        }
    }
}
