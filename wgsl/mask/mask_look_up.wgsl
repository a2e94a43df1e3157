// mask, look up: the share of each light of some masks that reaches a pixel. One invocation per pixel and
// group of masks. CPU reference: crates/gobo-reference/src/mask.rs. Rust: src/stage/mask.rs.

import package::bind::sampled::{mask_points, mask_surfaces};
import package::bind::uniform::mask_params;
import package::mask::mask_group::{MASKS, MaskGroup, even_group, shown_pixel, store_group};
import package::records::light::{cluster_list, cluster_of, light_record, listed_index};
import package::records::mask::{
    JOINED_BIT, mask_slot, pixel_number, slot_channels, slot_mask, surface_offset,
    unpack_mask_point, unpack_surface,
};
import package::shade::incoming::incoming;
import package::shade::receiver::set_receiver;
import package::shade::shadow::{UNSHADED, past_view, receiver_of};
import package::shade::taps::set_turn;
import choice::joined::host_shadow;

fn lowered(passed: vec4<f32>, slot: u32, is_mask: bool, share: vec3<f32>) -> vec4<f32> {
    let channels = slot_channels(slot) & vec4(is_mask);
    let is_colored = channels.x & channels.y;
    // Lights with one channel are blocked alike in all of them.
    return select(passed, min(passed, select(vec4(share.g), vec4(share, 1.0), is_colored)), channels);
}

@compute @workgroup_size(8, 8)
fn mask_look_up(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    var masks = even_group(1.0);
    var passed = UNSHADED;
    var i = 0u; // in the list of the pixel's lights
    // A turn reads one view of a light, and reads the pixel and the light for it: an area light leaves no
    // registers to keep them.
    loop {
        let texel = textureLoad(mask_surfaces, id.xy, 0);
        let surface = unpack_surface(texel);
        let receiver = unpack_mask_point(textureLoad(mask_points, id.xy, 0));
        let pixel = shown_pixel(id.xy, mask_params.step, surface_offset(texel));
        let list = cluster_list(cluster_of(pixel, surface.depth));
        let count = select(0u, list.count, surface.depth < 1.0);
        // Skips the lights of other masks.
        var index = 0u;
        var slot = 0u;
        while i < count {
            index = listed_index(list, i);
            slot = mask_slot(index);
            if (slot != 0u) & (slot_mask(max(slot, 1u)) / MASKS == id.z) {
                break;
            }
            i += 1u;
        }
        if i >= count {
            break;
        }
        set_turn(pixel_number(pixel));
        set_receiver(receiver.receives, receiver.tag, true);
        let light = light_record(index);
        let arriving = incoming(light, receiver.position);
        let is_lit = (dot(surface.normal, arriving.toward) > 0.0) & any(arriving.color > vec3(0.0));
        var joined = vec3(1.0);
        if ((slot & JOINED_BIT) != 0u) & is_lit {
            joined = host_shadow(index, receiver.position, surface.normal);
        }
        let is_last = i + 1u >= count;
        passed.is_all = true;
        if is_lit & (light.view_count > 0u) {
            // As in `point_light` for opaque points.
            let faces = dot(surface.face, arriving.toward) > 0.0;
            let face = select(surface.normal, surface.face, faces);
            let at = receiver_of(light, receiver.position, face, arriving.toward, surface.reach);
            passed = past_view(passed, light, at);
        }
        if passed.is_all {
            masks = lowered_group(masks, slot, id.z * MASKS, passed.light * joined);
            passed = UNSHADED;
            i += 1u;
            if is_last {
                break;
            }
        }
    }
    store_group(id.xy, id.z, masks);
}

// `first`: the first mask of the group.
fn lowered_group(masks: MaskGroup, slot: u32, first: u32, share: vec3<f32>) -> MaskGroup {
    let mask = slot_mask(slot) - first;
    var lower = masks;
    lower.first = lowered(masks.first, slot, mask == 0u, share);
    if MASKS > 1u {
        lower.second = lowered(masks.second, slot, mask == 1u, share);
    }
    if MASKS > 2u {
        lower.third = lowered(masks.third, slot, mask == 2u, share);
        lower.fourth = lowered(masks.fourth, slot, mask == 3u, share);
    }
    return lower;
}
