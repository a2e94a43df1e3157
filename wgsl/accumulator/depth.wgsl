// Accumulator: nearest opaque depth of four texels. CPU reference: src/reference/occlude.rs.

import package::features::ROLLED;
import package::hit::blocks::{blocks, stored_depth};
import package::hit::caster_hit::caster_hit;
import package::records::footprint::Footprint;
import package::records::view::GpuView;

const ROWS: u32 = 4u; // texels that an invocation holds, in a column

var<private> corner: vec2<f32>; // first of the four texels, in the view's map
var<private> nearest: vec4<f32>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest = vec4(1.0);
}

fn visit_texel(view: GpuView, footprint: Footprint, i: u32) {
    let texel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = caster_hit(view, footprint, texel, 1.0);
    if blocks(view, footprint, texel, hit) {
        nearest[i] = min(nearest[i], stored_depth(hit));
    }
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    for (var i = 0u; ROLLED && i < 4u; i += 1u) {
        visit_texel(view, footprint, i);
    }
    if !ROLLED {
        visit_texel(view, footprint, 0u);
        visit_texel(view, footprint, 1u);
        visit_texel(view, footprint, 2u);
        visit_texel(view, footprint, 3u);
    }
}

fn nearest_texel(i: u32) -> f32 {
    return nearest[i];
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    return all(nearest <= vec4(front));
}
