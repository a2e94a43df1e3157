// resolve, ordered: filter and nearest depth of the tiles that several workgroups or the scatter
// path added to, where the order counts: a tile's segments, front to back, then what was scattered.
// Leaves the sums zero. One workgroup per tile, four texels per invocation. CPU twin:
// src/reference/accumulate.rs, src/reference/resolve.rs. Host: src/stage/resolve.rs.

import package::bind::read::{dispatches, merged_tiles, partials};
import package::bind::sampled::tiles;
import package::bind::stored::{filters, nearests};
import package::bind::uniform::views;
import package::features::{HAS_GAIN, HAS_OWNERS, HAS_VOLUMES};
import package::records::dispatch::MERGED_DISPATCH;
import package::records::owner::{NO_OWNER, tagged_alpha, tagged_depth};
import package::records::record::record_texel;
import package::records::tile::{segment_count, tile_of};
import package::records::view::TILE_SIZE;
import package::sums::partial::{PARTIAL_TEXELS, Partial, partial_room, unpack_pair};
import package::sums::sums::{blackened, light, nearness_to_depth};
import package::walk::lane::{LANES, lane_texel, sum_index};
import choice::sums::{clear_sums, load_nearness, load_sums};

fn load_partial(texel: u32) -> Partial {
    let bits = partials[texel * PARTIAL_TEXELS];
    var signed = vec4(0);
    if HAS_VOLUMES || HAS_OWNERS {
        signed = bitcast<vec4<i32>>(partials[texel * PARTIAL_TEXELS + 1u]);
    }
    let middle = unpack_pair(bits.y);
    return Partial(
        vec3(unpack_pair(bits.x), middle.x),
        vec3(middle.y, unpack_pair(bits.z)),
        bitcast<f32>(bits.w),
        signed.xyz,
        (signed.w << 16u) >> 16u,
        bitcast<u32>(signed.w) >> 16u,
    );
}

@compute @workgroup_size(LANES)
fn resolve_ordered(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let slot = workgroup.y * workgroups.x + workgroup.x;
    if slot >= dispatches[MERGED_DISPATCH].w {
        return;
    }
    let id = merged_tiles[slot];
    let tile = tile_of(textureLoad(tiles, record_texel(id), 0));
    let view = views[tile.view];
    let place = lane_texel(lane);
    let room = partial_room(arrayLength(&partials));
    let first = tile.merged - 1u;
    let count = segment_count(tile);
    let composed = select(0u, min(count, max(room, first) - first), count > 1u);
    for (var i = 0u; i < 4u; i += 1u) {
        let sum = sum_index(id, place + vec2(0u, i));
        var passed = vec3(1.0);
        var tau = vec3(0);
        var leaves = 0;
        var owner = NO_OWNER;
        var nearest = nearness_to_depth(load_nearness(sum));
        for (var k = 0u; k < composed; k += 1u) {
            let partial = load_partial(sum_index(first + k, place + vec2(0u, i)));
            passed = passed * partial.scale + partial.added;
            owner = select(owner, partial.owner, partial.nearest < nearest);
            nearest = min(nearest, partial.nearest);
            tau += partial.tau;
            leaves += partial.leaves;
        }
        if leaves > 0 {
            nearest = 0.0; // the light is inside
        }
        tau += bitcast<vec3<i32>>(load_sums(sum));
        if !HAS_GAIN {
            tau = max(tau, vec3(0)); // a body that is not closed would brighten
        }
        passed *= light(bitcast<vec3<u32>>(tau));
        let at = view.origin + tile.place * TILE_SIZE + place + vec2(0u, i);
        var alpha = 1.0;
        if HAS_OWNERS {
            alpha = tagged_alpha(owner);
            nearest = tagged_depth(nearest, owner);
        }
        textureStore(filters, at, view.layer, vec4(blackened(passed), alpha));
        textureStore(nearests, at, view.layer, vec4(nearest));
        clear_sums(sum);
    }
}
