// mask, look up: the share of each light of some masks that reaches a pixel. One invocation per pixel and
// group of masks. CPU reference: crates/gobo-reference/src/mask.rs. Rust: src/stage/mask.rs.

import package::bind::sampled::{mask_points, mask_surfaces};
import package::bind::uniform::mask_params;
import package::mask::mask_group::{MASKS, even_group, shown_pixel, store_group};
import package::records::light::{cluster_list, cluster_of, light_record, listed_index};
import package::records::mask::{
    JOINED_BIT, mask_slot, pixel_number, slot_channels, slot_mask, surface_depth, surface_offset,
    unpack_mask_point, unpack_surface,
};
import package::shade::asides::{ASIDE_LOCAL, floats_of};
import package::shade::incoming::incoming;
import package::shade::receiver::set_receiver;
import package::shade::shadow::shadow;
import package::shade::taps::set_turn;
import choice::aside::{aside, lay_aside, open_asides};
import choice::joined::host_shadow;

// Laid aside: the pixel, and the share that passes of the first mask's lights.
const ASIDE_TEXEL: u32 = ASIDE_LOCAL;
const ASIDE_PASSED_FIRST: u32 = ASIDE_LOCAL + 1u;
const LOCAL_ASIDES: u32 = 2u;

fn lowered(passed: vec4<f32>, slot: u32, is_mask: bool, share: vec3<f32>) -> vec4<f32> {
    let channels = slot_channels(slot) & vec4(is_mask);
    let is_colored = channels.x && channels.y;
    // Lights with one channel are blocked alike in all of them.
    return select(passed, min(passed, select(vec4(share.g), vec4(share, 1.0), is_colored)), channels);
}

@compute @workgroup_size(8, 8)
fn mask_look_up(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    open_asides(lane);
    lay_aside(ASIDE_TEXEL, vec4(id.xy, 0u, 0u));
    lay_aside(ASIDE_PASSED_FIRST, bitcast<vec4<u32>>(vec4(1.0)));
    let depth = surface_depth(textureLoad(mask_surfaces, id.xy, 0));
    let offset = surface_offset(textureLoad(mask_surfaces, id.xy, 0));
    let receiver = unpack_mask_point(textureLoad(mask_points, id.xy, 0));
    let pixel = shown_pixel(id.xy, mask_params.step, offset);
    let list = cluster_list(cluster_of(pixel, depth));
    let count = select(0u, list.count, depth < 1.0);
    set_turn(pixel_number(pixel));
    set_receiver(receiver.receives, receiver.tag, true);
    let first = id.z * MASKS;
    var rest = even_group(1.0); // the first mask is laid aside
    while aside(ASIDE_TEXEL).z < count {
        // Skips the lights of other masks, which the rest of the loop would compute in vain.
        let before = aside(ASIDE_TEXEL);
        var next = before.z;
        var index = 0u;
        var slot = 0u;
        while slot == 0u && next < count {
            index = listed_index(list, next);
            let found = mask_slot(index);
            slot = select(0u, found, found != 0u && slot_mask(max(found, 1u)) / MASKS == id.z);
            next += 1u;
        }
        let texel = before.xy;
        lay_aside(ASIDE_TEXEL, vec4(texel, next, slot));
        let surface = unpack_surface(textureLoad(mask_surfaces, texel, 0));
        let position = unpack_mask_point(textureLoad(mask_points, texel, 0)).position;
        var light = light_record(index);
        let arriving = incoming(light, position);
        let is_lit = dot(surface.normal, arriving.toward) > 0.0 && any(arriving.color > vec3(0.0));
        // As in `point_light` for opaque points.
        let faces = dot(surface.face, arriving.toward) > 0.0;
        let face = select(surface.normal, surface.face, faces);
        // A light without views reads no map.
        light.view_count = select(0u, light.view_count, is_lit && slot != 0u);
        var share = shadow(light, index, position, face, arriving.toward, surface.reach);
        let after = aside(ASIDE_TEXEL);
        if (after.w & JOINED_BIT) != 0u && is_lit {
            share *= host_shadow(index, position, surface.normal);
        }
        let mask_slot = max(after.w, 1u);
        let mask = select(MASKS, slot_mask(mask_slot) - first, after.w != 0u);
        let passed = floats_of(aside(ASIDE_PASSED_FIRST));
        lay_aside(ASIDE_PASSED_FIRST, bitcast<vec4<u32>>(lowered(passed, mask_slot, mask == 0u, share)));
        if MASKS > 1u {
            rest.second = lowered(rest.second, mask_slot, mask == 1u, share);
        }
        if MASKS > 2u {
            rest.third = lowered(rest.third, mask_slot, mask == 2u, share);
            rest.fourth = lowered(rest.fourth, mask_slot, mask == 3u, share);
        }
    }
    rest.first = floats_of(aside(ASIDE_PASSED_FIRST));
    store_group(aside(ASIDE_TEXEL).xy, id.z, rest);
}
