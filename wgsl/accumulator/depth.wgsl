// Accumulator: nearest opaque depth of an invocation's texels. CPU reference:
// crates/gobo-reference/src/occlude.rs.

import package::features::unrolled;
import package::hit::blocks::{blocks, stored_depth};
import package::hit::caster_hit::caster_hit;
import package::records::footprint::Footprint;
import package::records::view::GpuView;
import choice::rows::ROW_COUNT;

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> nearest: array<f32, ROWS>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        nearest[i] = 1.0;
    }
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let texel = corner + vec2(0.5, f32(i) + 0.5);
        let hit = caster_hit(view, footprint, texel, 1.0);
        if blocks(view, footprint, texel, hit) {
            nearest[i] = min(nearest[i], stored_depth(hit));
        }
    }
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    var last = 0.0;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        last = max(last, nearest[i]);
    }
    return last <= front;
}
