// Visits an invocation's texels with a caster of any kind whose curves are made by two walks.

import package::curve::ray::{RayHit, ROWS, corner, texels, visit_hit};
import package::features::unrolled;
import package::hit::caster_hit::{faced_hit, set_up};
import package::hit::hit::presence_of;
import package::records::footprint::Footprint;
import package::records::view::GpuView;

const READS_OPAQUE: bool = true; // whatever the casters
const OFTEN_FEW: bool = true;

fn visit_caster(view: GpuView, footprint: Footprint) {
    let faced = set_up(view, footprint);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        let hit = faced_hit(view, footprint, faced, corner + vec2(0.5, f32(i) + 0.5), texel.opaque);
        let is = hit.depth >= 0.0 && hit.depth < texel.opaque;
        let absorbed = select(vec3(0.0), hit.absorbed, is);
        let presence = select(0.0, presence_of(hit), is);
        visit_hit(view, &texel, i, RayHit(absorbed, hit.depth, hit.start, hit.end, presence));
        texels[i] = texel;
    }
}
