// Look-up of shadow masks, at opaque points. CPU reference: crates/gobo-reference/src/shading/mod.rs.

import package::bind::sampled::light_masks;
import package::records::mask::{mask_slot, slot_channels, slot_mask};
import package::records::point::{POINT_SOLID, Point};

// Share of a light from its mask, 1 without a mask; and whether it has one.
struct Masked {
    share: vec3<f32>,
    is_masked: bool,
}

fn masked(light: u32, point: Point) -> Masked {
    let slot = mask_slot(light);
    let is_masked = slot != 0u && point.kind == POINT_SOLID;
    let mask_slot = max(slot, 1u);
    let pixel = vec2(point.pixel & 0xffffu, point.pixel >> 16u);
    let mask = textureLoad(light_masks, pixel, slot_mask(mask_slot), 0);
    let channels = slot_channels(mask_slot);
    let one = dot(mask, select(vec4(0.0), vec4(1.0), channels));
    let share = select(vec3(one), mask.rgb, channels.x && channels.y);
    return Masked(select(vec3(1.0), share, is_masked), is_masked);
}
