// accumulate, ordered: what one segment of a long tile does to the light of its texels, where the
// order counts; resolve_ordered composes a tile's segments. One workgroup per segment, a column of
// texels per invocation. A tile's only segment is a plain factor of what was scattered there, and
// goes to the sums; so does what `partials` has no room for, which takes more scattered tiles than
// the pair budget has segments. CPU twin: src/reference/accumulate.rs. Host: src/stage/accumulate.rs.

import package::bind::changed::partials;
import package::bind::read::{dispatches, segments};
import package::bind::sampled::tiles;
import package::bind::uniform::views;
import package::features::{HAS_OWNERS, HAS_VOLUMES};
import package::records::dispatch::SEGMENT_DISPATCH;
import package::records::owner::NO_OWNER;
import package::records::record::record_texel;
import package::records::tile::{segment_count, tile_of};
import package::state::filter::{added, crossed, nearest, nearest_texel, owner, passed, start};
import package::sums::merge::merge;
import package::sums::partial::{PARTIAL_TEXELS, Partial, pack_partial, partial_room};
import package::sums::sums::{FIXED_ONE, depth_to_nearness, to_tau};
import package::walk::lane::{LANES, lane_texel, sum_index, tile_texel};
import choice::rows::ROWS;
import choice::sums::{add_to_sums, raise_nearness};
import choice::walk::walk;

@compute @workgroup_size(LANES)
fn accumulate_ordered(
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
    let composed = index < partial_room(arrayLength(&partials)) && segment_count(tile_of(textureLoad(tiles, record_texel(segment.tile), 0))) > 1u;
    for (var i = 0u; i < ROWS; i += 1u) {
        if composed {
            let at = PARTIAL_TEXELS * sum_index(index, place + vec2(0u, i));
            partials[at] = pack_partial(Partial(passed[i], added[i], nearest[i], vec3(0), 0, NO_OWNER));
            if HAS_VOLUMES || HAS_OWNERS {
                let leaves = bitcast<u32>(crossed[i].w) & 0xffffu;
                let tau = bitcast<vec3<u32>>(crossed[i].xyz);
                partials[at + 1u] = vec4(tau, leaves | (owner[i] << 16u));
            }
        } else {
            let sum = sum_index(segment.tile, place + vec2(0u, i));
            let tau = vec3<i32>(round(to_tau(passed[i] + added[i]) * FIXED_ONE));
            if HAS_VOLUMES {
                add_to_sums(sum, bitcast<vec3<u32>>(tau + crossed[i].xyz));
            } else {
                merge(sum, bitcast<vec3<u32>>(tau));
            }
            if nearest_texel(i) < 1.0 {
                raise_nearness(sum, depth_to_nearness(nearest_texel(i)));
            }
        }
    }
}
