// Output: filter and nearest depth with order-dependent blending. A segment of a long tile stores its
// transfer to the light of its texels; a tile's segments are composed front to back, then the scattered
// casters. A tile's only segment is a factor beside its scattered casters, and is added to the sums; so are
// segments past the capacity of `partials`, when more tiles have scattered casters than the pair budget has
// segments. CPU reference: crates/gobo-reference/src/accumulate.rs, crates/gobo-reference/src/resolve.rs.

import package::accumulator::filter::{ROWS, finish, found, texels};
import package::bind::changed::partials;
import package::bind::stored::{filters, nearests};
import package::features::{HAS_GAIN, HAS_OWNERS, HAS_VOLUMES, unrolled};
import package::records::texel::{NO_OWNER, tagged_alpha, tagged_depth};
import package::records::tile::{Segment, Tile, is_first_segment, is_last_segment, segment_count};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::scatter::{PARTIAL_TEXELS, Partial, merge, pack_partial, partial_capacity, unpack_pair};
import package::sums::sums::{FIXED_ONE, blackened, depth_to_nearness, light, nearness_to_depth, to_tau};
import package::traversal::lane::sum_index;
import choice::sums::{add_to_sums, clear_sums, load_nearness, load_sums, raise_nearness};

fn store_segment(segment: Segment, index: u32, in_tile: vec2<u32>) {
    finish();
    let is_only = is_first_segment(segment) & is_last_segment(segment);
    let composed = index < partial_capacity(arrayLength(&partials)) && !is_only;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let texel = texels[i];
        if composed {
            let at = PARTIAL_TEXELS * sum_index(index, in_tile + vec2(0u, i));
            let transfer = Partial(texel.passed, texel.added, texel.nearest, vec3(0), 0, NO_OWNER);
            partials[at] = pack_partial(transfer);
            if HAS_VOLUMES || HAS_OWNERS {
                let leaves = bitcast<u32>(texel.crossed.w) & 0xffffu;
                let tau = bitcast<vec3<u32>>(texel.crossed.xyz);
                partials[at + 1u] = vec4(tau, leaves | (texel.owner << 16u));
            }
        } else {
            let sum = sum_index(segment.tile, in_tile + vec2(0u, i));
            let tau = vec3<i32>(round(to_tau(texel.passed + texel.added) * FIXED_ONE));
            if HAS_VOLUMES {
                add_to_sums(sum, bitcast<vec3<u32>>(tau + texel.crossed.xyz));
            } else {
                merge(sum, bitcast<vec3<u32>>(tau));
            }
            if found[i].nearest < 1.0 {
                raise_nearness(sum, depth_to_nearness(found[i].nearest));
            }
        }
    }
}

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

fn resolve(view: GpuView, tile: Tile, tile_id: u32, in_tile: vec2<u32>) {
    let capacity = partial_capacity(arrayLength(&partials));
    let first = tile.merged - 1u;
    let count = segment_count(tile);
    let composed = select(0u, min(count, max(capacity, first) - first), count > 1u);
    for (var i = 0u; i < ROWS; i += 1u) {
        let sum = sum_index(tile_id, in_tile + vec2(0u, i));
        var passed = vec3(1.0);
        var tau = vec3(0);
        var leaves = 0;
        var owner = NO_OWNER;
        var nearest = nearness_to_depth(load_nearness(sum));
        for (var k = 0u; k < composed; k += 1u) {
            let partial = load_partial(sum_index(first + k, in_tile + vec2(0u, i)));
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
            tau = max(tau, vec3(0)); // a mesh that is not closed would brighten
        }
        passed *= light(bitcast<vec3<u32>>(tau));
        let at = view.origin + tile.position * TILE_SIZE + in_tile + vec2(0u, i);
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
