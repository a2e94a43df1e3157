// shade, seen: the nearest solid caster of each pixel of a long tile, one segment at a time; one
// workgroup per segment, four pixels per invocation. shade_surfaces takes the nearest of them. CPU
// twin: src/reference/shade/mod.rs. Host: src/stage/shade.rs.

import package::bind::changed::partials;
import package::bind::read::{dispatches, segments};
import package::bind::uniform::views;
import package::records::dispatch::SEGMENT_DISPATCH;
import package::shade::cost::walked;
import package::state::seen::{nearest, seen, setup_of, start};
import package::walk::lane::{LANES, lane_texel, sum_index, tile_texel};
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn shade_seen(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup.y * workgroups.x + workgroup.x;
    if index >= dispatches[SEGMENT_DISPATCH].w {
        return;
    }
    let segment = segments[index];
    let view = views[0];
    let place = lane_texel(lane);
    start(view, tile_texel(view, segment.tile) + place);
    walk(view, segment.first, segment.end);
    for (var i = 0u; i < 4u; i += 1u) {
        let partial = vec4(bitcast<u32>(nearest[i]), seen[i], setup_of[i], walked);
        partials[sum_index(index, place + vec2(0u, i))] = partial;
    }
}
