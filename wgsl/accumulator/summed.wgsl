// Accumulator: sums over the casters of an invocation's texels, in registers, to which the sums of other
// casters are added. CPU reference: crates/gobo-reference/src/sums.rs.

import package::bind::sampled::opaques;
import package::features::{HAS_GAIN, unrolled};
import package::hit::caster_hit::{faced_hit, set_up};
import package::records::footprint::Footprint;
import package::records::view::GpuView;
import package::sums::scatter::addend;
import package::sums::sums::{SATURATED, nearness_to_depth};
import choice::rows::ROW_COUNT;

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> ends: array<f32, ROWS>; // light depths of the opaque surface
var<private> totals: array<vec4<u32>, ROWS>; // optical depth per channel, and nearness

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        ends[i] = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
        totals[i] = vec4(0u);
    }
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    let faced = set_up(view, footprint);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = corner + vec2(0.5, f32(i) + 0.5);
        let total = totals[i];
        let added = addend(footprint, faced_hit(view, footprint, faced, at, ends[i]), ends[i]);
        // A saturated sum is black whatever is added, and would wrap.
        let full = (total.xyz >= vec3(SATURATED)) & vec3(!HAS_GAIN);
        totals[i] = vec4(total.xyz + select(added.xyz, vec3(0u), full), max(total.w, added.w));
    }
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    var open = HAS_GAIN;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let lit = any(totals[i].xyz < vec3(SATURATED)) || nearness_to_depth(totals[i].w) > front;
        open = open || (lit && ends[i] > front);
    }
    return !open;
}
