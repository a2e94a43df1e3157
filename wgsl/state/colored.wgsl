// The state of four texels while the nearest opaque surface of each channel is sought. CPU twin:
// src/reference/colored.rs.

import package::features::ROLLED;
import package::hit::blocks::stored_depth;
import package::hit::blocks_colored::blocked_channels;
import package::hit::caster_hit::caster_hit;
import package::records::view::GpuView;

var<private> corner: vec2<f32>; // first of the four texels, in the view's map
var<private> nearest: array<vec3<f32>, 4>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest[0] = vec3(1.0);
    nearest[1] = vec3(1.0);
    nearest[2] = vec3(1.0);
    nearest[3] = vec3(1.0);
}

fn visit_texel(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) {
    let texel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = caster_hit(view, place, look, texel, 1.0);
    let blocked = blocked_channels(view, place, look, texel, hit);
    nearest[i] = select(nearest[i], min(nearest[i], vec3(stored_depth(hit))), blocked);
}

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    for (var i = 0u; ROLLED && i < 4u; i += 1u) {
        visit_texel(view, place, look, i);
    }
    if !ROLLED {
        visit_texel(view, place, look, 0u);
        visit_texel(view, place, look, 1u);
        visit_texel(view, place, look, 2u);
        visit_texel(view, place, look, 3u);
    }
}

// Nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    let last = max(max(nearest[0], nearest[1]), max(nearest[2], nearest[3]));
    return all(last <= vec3(front));
}
