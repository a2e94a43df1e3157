// accumulate, ordered: what one segment of a long tile does to the light of its texels, where the
// order counts; resolve_ordered composes a tile's segments. One workgroup per segment, a column of
// texels per invocation. A tile's only segment is a plain factor of what was scattered there, and
// goes to the sums; so does what `partials` has no room for, which takes more scattered tiles than
// the pair budget has segments. CPU twin: src/reference/accumulate.rs. Host: src/stage/accumulate.rs.

import package::bind::changed::partials;
import package::bind::loaded::{footprints, pairs};
import package::bind::read::{dispatches, segments};
import package::bind::sampled::tiles;
import package::bind::uniform::views;
import package::features::{HAS_OVER, HAS_OWNERS, HAS_VOLUMES};
import package::hit::key_depths::front_depths;
import package::hit::reach::front_depth;
import package::records::dispatch::SEGMENT_DISPATCH;
import package::records::owner::NO_OWNER;
import package::records::record::{FOOTPRINT_TEXELS, record_texel};
import package::records::tile::{segment_count, tile_of};
import package::state::filter::{
    added_texel, crossed, finish, nearest, nearest_texel, own_before, own_faces, own_from, owner,
    passed, start,
};
import package::sums::merge::merge;
import package::sums::partial::{PARTIAL_TEXELS, Partial, pack_partial, partial_room};
import package::sums::sums::{FIXED_ONE, depth_to_nearness, to_tau};
import package::walk::lane::{LANES, lane_texel, sum_index, tile_texel};
import choice::rows::ROWS;
import choice::sums::{add_to_sums, raise_nearness};
import choice::walk::walk;

// Pairs at the end of a segment whose hits go to the next one where they lie behind its front.
const OVERLAP: u32 = 256u;

fn pair_front(pair: u32) -> f32 {
    let footprint = textureLoad(pairs, record_texel(pair)).g;
    return front_depth(textureLoad(footprints, record_texel(footprint * FOOTPRINT_TEXELS + 1u)));
}

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
    let tile = tile_of(textureLoad(tiles, record_texel(segment.tile), 0));
    start(view, tile_texel(view, segment.tile) + place);
    // Hits of the last pairs of the segment before that lie behind the front of this one; its own pairs;
    // its last ones, of which what lies behind the front of the next is not its own.
    let before = select(segment.first, segment.first - OVERLAP, segment.first > tile.first);
    let last = select(segment.end, segment.end - OVERLAP, segment.end < tile.end);
    for (var part = select(1u, 0u, HAS_OVER); part < select(2u, 3u, HAS_OVER); part += 1u) {
        var first = segment.first;
        var end = segment.end;
        if HAS_OVER {
            first = select(select(before, first, part == 1u), last, part == 2u);
            end = select(select(end, last, part == 1u), segment.first, part == 0u);
            // Where there is no such segment, neither are there such pairs.
            let front = front_depths(pair_front(min(end, tile.end - 1u)));
            own_from = select(vec4(-1.0), front, part == 0u);
            own_before = select(vec4(2.0), front, part == 2u);
            own_faces = part > 0u;
        }
        walk(view, first, end);
    }
    finish();
    let composed = index < partial_room(arrayLength(&partials)) && segment_count(tile) > 1u;
    for (var i = 0u; i < ROWS; i += 1u) {
        if composed {
            let at = PARTIAL_TEXELS * sum_index(index, place + vec2(0u, i));
            partials[at] = pack_partial(Partial(passed[i], added_texel(i), nearest[i], vec3(0), 0, NO_OWNER));
            if HAS_VOLUMES || HAS_OWNERS {
                let leaves = bitcast<u32>(crossed[i].w) & 0xffffu;
                let tau = bitcast<vec3<u32>>(crossed[i].xyz);
                partials[at + 1u] = vec4(tau, leaves | (owner[i] << 16u));
            }
        } else {
            let sum = sum_index(segment.tile, place + vec2(0u, i));
            let tau = vec3<i32>(round(to_tau(passed[i] + added_texel(i)) * FIXED_ONE));
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
