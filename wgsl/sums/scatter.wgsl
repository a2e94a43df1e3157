// Sums of several invocations. CPU reference: crates/gobo-reference/src/sums.rs and
// crates/gobo-reference/src/accumulate.rs, `Passed`.

import package::bind::changed::scattered_tiles;
import package::bind::sampled::opaques;
import package::features::{HAS_GAIN, HAS_OVER, HAS_VOLUMES};
import package::hit::caster_hit::caster_hit;
import package::hit::crossing::{added_light, crossing};
import package::hit::hash::unit_float;
import package::hit::hit::{Hit, presence_of};
import package::records::caster::object_of;
import package::records::footprint::{Footprint, caster_of};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::sums::{FIXED_ONE, SATURATED, VISIBLE_PRESENCE, absorbed_tau, depth_to_nearness};
import package::traversal::lane::sum_index;
import choice::sums::{add_to_sums, load_sums, raise_nearness};

// Adds a caster or a segment to the sums of a texel.  Bit-identical in every order: a saturated sum is black
// whatever is added.

// Largest addend of one of many invocations at a time: 1,024 workgroups of 256 do not wrap a sum that all of
// them saw below `SATURATED`. Rust: src/stage/accumulate.rs.
const LARGEST_STEP: u32 = 16380u;

fn merge(texel: u32, tau: vec3<u32>) {
    let sums = load_sums(texel);
    if HAS_GAIN {
        add_to_sums(texel, tau);
    } else if any(sums < vec3(SATURATED)) && any(tau != vec3(0u)) {
        add_to_sums(texel, select(tau, vec3(0u), sums >= vec3(SATURATED)));
    }
}

// Like `merge`, for so many invocations at a time that their addends would wrap the sum: in steps, each after
// a look at the sum.
fn merge_in_steps(texel: u32, tau: vec3<u32>) {
    if HAS_GAIN {
        add_to_sums(texel, tau);
        return;
    }
    var left = tau;
    loop {
        left = select(left, vec3(0u), load_sums(texel) >= vec3(SATURATED));
        let step = min(left, vec3(LARGEST_STEP));
        if any(step != vec3(0u)) {
            add_to_sums(texel, step);
        }
        left -= step;
        if all(left == vec3(0u)) {
            break;
        }
    }
}

// Adds one caster's light at one texel straight to the sums: the scatter path.

// Dither added before rounding down, with channels a third apart: multiples of the golden ratio, whose sums
// over runs of casters deviate less than random ones.
fn spread(id: u32) -> vec3<f32> {
    let turn = id * 2654435769u;
    return vec3(unit_float(turn), unit_float(turn + 0x55555555u), unit_float(turn + 0xaaaaaaaau));
}

// Addend of a hit to the sums of a texel: optical depth per channel, and nearness; 0 behind the opaque
// surface.
fn addend(footprint: Footprint, hit: Hit, opaque_depth: f32) -> vec4<u32> {
    if !(hit.depth >= 0.0 && hit.depth < opaque_depth) {
        return vec4(0u);
    }
    // Dithered rounding, so that a million equal casters don't add up their rounding errors.
    var seed = caster_of(footprint);
    if !footprint.is_triangle {
        seed = object_of(footprint);
    }
    let chance = spread(seed);
    var hit_tau = absorbed_tau(hit.absorbed);
    if HAS_OVER {
        // Without order: as if it were the only caster.
        hit_tau = absorbed_tau(hit.absorbed - added_light(hit));
    }
    let tau = bitcast<vec3<u32>>(vec3<i32>(floor(hit_tau * FIXED_ONE + chance)));
    return vec4(tau, select(0u, depth_to_nearness(hit.depth), presence_of(hit) >= VISIBLE_PRESENCE));
}

fn scatter(view: GpuView, footprint: Footprint, texel: vec2<u32>) {
    let opaque_depth = textureLoad(opaques, view.origin + texel, view.layer, 0).r;
    let hit = caster_hit(view, footprint, vec2<f32>(texel) + 0.5, opaque_depth);
    let tile_xy = texel / TILE_SIZE;
    let tile = view.first_tile + tile_xy.y * view.tiles_x + tile_xy.x;
    let sum = sum_index(tile, texel % TILE_SIZE);
    if HAS_VOLUMES {
        let crossed = crossing(view, footprint, vec2<f32>(texel) + 0.5, opaque_depth);
        if crossed.w != 0 {
            add_to_sums(sum, bitcast<vec3<u32>>(crossed.xyz));
            scattered_tiles[tile] = 1u;
        }
    }
    let added = addend(footprint, hit, opaque_depth);
    if all(added == vec4(0u)) {
        return;
    }
    if HAS_VOLUMES {
        add_to_sums(sum, added.xyz);
    } else {
        merge_in_steps(sum, added.xyz);
    }
    raise_nearness(sum, added.w);
    scattered_tiles[tile] = 1u;
}

// Transfer of a segment to the light of one texel, which `resolve` composes in order: L becomes L * scale +
// added.
struct Partial {
    scale: vec3<f32>,
    added: vec3<f32>,
    nearest: f32,
    tau: vec3<i32>, // of volumes, modulo 2^32
    leaves: i32,    // volumes that the ray leaves, minus those that it enters
    owner: u32,
}

const PARTIAL_TEXELS: u32 = 2u; // of `partials`; Rust: src/shadows/batch/scratch.rs

// A half has the range that `gain` needs, but only 11 bits.
fn pack_pair(v: vec2<f32>) -> u32 {
    if HAS_GAIN {
        return pack2x16float(min(v, vec2(65504.0)));
    }
    return pack2x16unorm(v);
}

fn unpack_pair(bits: u32) -> vec2<f32> {
    if HAS_GAIN {
        return unpack2x16float(bits);
    }
    return unpack2x16unorm(bits);
}

fn pack_partial(p: Partial) -> vec4<u32> {
    return vec4(
        pack_pair(p.scale.rg),
        pack_pair(vec2(p.scale.b, p.added.r)),
        pack_pair(p.added.gb),
        bitcast<u32>(p.nearest),
    );
}

// Number of segments that fit in `length` texels of `partials`.
fn partial_capacity(length: u32) -> u32 {
    return length / (PARTIAL_TEXELS * sum_index(1u, vec2(0u)));
}
