// mask, look up: the light that each light of a mask still sends to a pixel. One invocation per pixel and
// mask. CPU twin: src/reference/mask.rs. Host: src/stage/mask.rs.

import package::bind::sampled::mask_surfaces;
import package::bind::stored::new_masks;
import package::bind::uniform::{mask_params, views};
import package::mask::mask_pixel::shown_pixel;
import package::records::light::{cluster_list, cluster_of, light_record, listed_index};
import package::records::mask::{mask_slot, slot_channels, slot_mask, unpack_surface};
import package::records::point::pixel_number;
import package::shade::receive::{incoming, shadow};
import package::shade::receiver::set_receiver;
import package::shade::surface::world_point;
import package::shade::taps::set_turn;

@compute @workgroup_size(8, 8)
fn mask_look_up(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= mask_params.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(mask_surfaces, id.xy, 0));
    let pixel = shown_pixel(id.xy, mask_params.step, surface);
    let position = world_point(views[0], pixel, surface.depth);
    let list = cluster_list(cluster_of(pixel, surface.depth));
    let count = select(0u, list.count, surface.depth < 1.0);
    set_turn(pixel_number(pixel));
    set_receiver(surface.receives, surface.tag, true);
    var passed = vec4(1.0);
    for (var i = 0u; i < count; i += 1u) {
        let index = listed_index(list, i);
        let slot = mask_slot(index);
        var light = light_record(index);
        let arriving = incoming(light, position);
        let is_lit = dot(surface.normal, arriving.toward) > 0.0 && any(arriving.color > vec3(0.0));
        // As `point_light` does of what is solid.
        let faces = dot(surface.face, arriving.toward) > 0.0;
        let face = select(surface.normal, surface.face, faces);
        let is_own = slot != 0u && slot_mask(max(slot, 1u)) == id.z;
        // A light without views asks no map.
        light.view_count = select(0u, light.view_count, is_lit && is_own);
        let share = shadow(light, position, face, arriving.toward, surface.reach);
        let channels = slot_channels(max(slot, 1u)) & vec4(is_own);
        let is_colored = channels.x && channels.y;
        // A mask of one channel is of what blocks all of them alike.
        passed = select(passed, min(passed, select(vec4(share.g), vec4(share, 1.0), is_colored)), channels);
    }
    textureStore(new_masks, id.xy, id.z, passed);
}
