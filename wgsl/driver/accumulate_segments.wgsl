// accumulate, segments: adds one segment of a long tile to the sums of its texels. One workgroup
// per segment, a column of texels per invocation; atomics, because segments of a tile run side by
// side. CPU twin: src/reference/accumulate.rs. Host: src/stage/accumulate.rs.

import package::bind::read::{dispatches, segments};
import package::bind::uniform::views;
import package::records::dispatch::SEGMENT_DISPATCH;
import package::sums::merge::merge;
import package::sums::sums::{FIXED_ONE, depth_to_nearness, to_tau};
import package::walk::lane::{LANES, lane_texel, sum_index, tile_texel};
import choice::rows::ROWS;
import choice::state::{nearest_texel, passed_texel, start};
import choice::sums::raise_nearness;
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn accumulate_segments(
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
    let texel = tile_texel(view, segment.tile) + place;
    start(view, texel);
    walk(view, segment.first, segment.end);
    // A copy: what a loop indexes is memory, and what the walk changes should be registers.
    var own: array<vec4<f32>, 8>;
    own[0] = own_texel(0u);
    own[1] = own_texel(1u);
    own[2] = own_texel(2u);
    own[3] = own_texel(3u);
    if ROWS > 4u {
        own[4] = own_texel(4u);
        own[5] = own_texel(5u);
        own[6] = own_texel(6u);
        own[7] = own_texel(7u);
    }
    for (var i = 0u; i < ROWS; i += 1u) {
        let sum = sum_index(segment.tile, place + vec2(0u, i));
        merge(sum, bitcast<vec3<u32>>(vec3<i32>(round(to_tau(own[i].rgb) * FIXED_ONE))));
        if own[i].a < 1.0 {
            raise_nearness(sum, depth_to_nearness(own[i].a));
        }
    }
}

// Light that passed, and the nearest depth.
fn own_texel(i: u32) -> vec4<f32> {
    return vec4(passed_texel(i), nearest_texel(i));
}
