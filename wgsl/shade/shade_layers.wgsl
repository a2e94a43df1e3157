// shade, layers: what a segment of a long tile lays over each pixel; one workgroup per segment,
// four pixels per invocation. Light L behind it becomes colour + passed * L, so that
// shade_composite composes the segments of a tile in order. CPU twin: src/reference/shade/mod.rs. Host:
// src/stage/shade.rs.

import package::bind::changed::partials;
import package::bind::read::{dispatches, segments};
import package::bind::uniform::views;
import package::records::dispatch::SEGMENT_DISPATCH;
import package::shade::cost::walked;
import package::state::layers::{asked_of, color, finish, passed, start};
import package::walk::lane::{LANES, lane_texel, sum_index, tile_texel};
import choice::walk::walk;

const BRIGHTEST: f32 = 60000.0; // that 16 bits hold

@compute @workgroup_size(LANES)
fn shade_layers(
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
    finish(view);
    for (var i = 0u; i < 4u; i += 1u) {
        let c = min(color[i], vec3(BRIGHTEST));
        let p = passed[i];
        let cost = walked | (asked_of[i] << 16u); // both are short of 16 bits
        let partial = vec4(pack2x16float(c.rg), pack2x16float(vec2(c.b, p.r)), pack2x16float(p.gb), cost);
        partials[sum_index(index, place + vec2(0u, i))] = partial;
    }
}
