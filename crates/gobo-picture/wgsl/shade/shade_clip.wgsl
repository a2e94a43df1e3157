// shade, clip: tiles of each footprint that are in a band, if the picture has too many pairs to bin at once.
// One invocation per footprint. Rust: crates/gobo-picture/src/stage/shade.rs.

import package::bind::picture_in::band;
import package::bind::uniform::point_batch;
import package::features::HAS_GAUSSIANS;
import package::records::outline::{is_outlined, load_outline, outlined_tiles};
import package::records::tile::WHOLE;
import choice::records::rect_record;
import choice::writes::write_clipped_rect;

override WORKGROUP_SIZE: u32;

@compute @workgroup_size(WORKGROUP_SIZE)
fn shade_clip(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    let footprint = id.y * workgroups.x * WORKGROUP_SIZE + id.x;
    if footprint >= point_batch.count {
        return;
    }
    let rect = rect_record(footprint);
    let caster_first = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let caster_last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
    let first = max(caster_first, band.origin);
    let last = min(caster_last, band.origin + band.size - 1u);
    let has_mask = all(caster_last - caster_first < vec2(4u));
    var mask = 0u;
    if all(first <= last) && (rect.y & 0xffffu) != 0u {
        mask = WHOLE;
        if all(last - first < vec2(4u)) {
            mask = 0u;
            for (var y = first.y; y <= last.y; y += 1u) {
                for (var x = first.x; x <= last.x; x += 1u) {
                    let mask_bit = (y - caster_first.y) * 4u + x - caster_first.x;
                    let touches = !has_mask || ((rect.y >> (mask_bit & 15u)) & 1u) != 0u;
                    mask |= select(0u, 1u << ((y - first.y) * 4u + x - first.x), touches);
                }
            }
        }
    }
    let corners = first.x | (first.y << 8u) | (last.x << 16u) | (last.y << 24u);
    var clipped = select(vec2(0u), vec2(corners, mask | (rect.y & 0xffff0000u)), mask != 0u);
    if HAS_GAUSSIANS && mask != 0u && is_outlined(rect) {
        clipped = outlined_tiles(load_outline(footprint), clipped);
    }
    write_clipped_rect(footprint, clipped);
}
