// Adds one caster's light at one texel straight to the sums: the scatter path.

import package::bind::changed::scattered_tiles;
import package::bind::sampled::opaques;
import package::features::{HAS_OVER, HAS_VOLUMES};
import package::hit::caster_hit::caster_hit;
import package::hit::hit::presence_of;
import package::hit::crossing::{added_light, crossing};
import package::hit::hash::unit_float;
import package::hit::object::object_of;
import package::records::footprint::{Footprint, caster_of};
import package::records::view::{GpuView, TILE_SIZE};
import package::sums::faint::absorbed_tau;
import package::sums::merge::merge_in_steps;
import package::sums::sums::{FIXED_ONE, VISIBLE_PRESENCE, depth_to_nearness};
import package::traversal::lane::sum_index;
import choice::sums::{add_to_sums, raise_nearness};

// Dither added before rounding down, with channels a third apart: multiples of the golden ratio, whose sums
// over runs of casters deviate less than random ones.
fn spread(id: u32) -> vec3<f32> {
    let turn = id * 2654435769u;
    return vec3(unit_float(turn), unit_float(turn + 0x55555555u), unit_float(turn + 0xaaaaaaaau));
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
    if !(hit.depth >= 0.0 && hit.depth < opaque_depth) {
        return;
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
    if HAS_VOLUMES {
        add_to_sums(sum, tau);
    } else {
        merge_in_steps(sum, tau);
    }
    if presence_of(hit) >= VISIBLE_PRESENCE {
        raise_nearness(sum, depth_to_nearness(hit.depth));
    }
    scattered_tiles[tile] = 1u;
}
