// Walks a tile's pairs front to back, twice.

import package::curve::ray::{ROWS, RayHit, begin_second, corner, texels, visit_hit};
import package::curve::ray_nodes::{end_walk, visit_scattered};
import package::features::unrolled;
import package::hit::caster_hit::{faced_hit, set_up};
import package::hit::hit::presence_of;
import package::records::footprint::Footprint;
import package::records::view::GpuView;
import choice::pass::visit_pairs;
import choice::written::WALKS_APART;

fn walk_once(view: GpuView, first: u32, end: u32) {
    visit_pairs(view, first, end);
    visit_scattered(view);
}

fn walk(view: GpuView, first: u32, end: u32) {
    if WALKS_APART {
        walk_once(view, first, end);
        begin_second();
        walk_once(view, first, end);
    } else {
        for (var turn = 0u; turn < 2u; turn += 1u) {
            if turn == 1u {
                begin_second();
            }
            walk_once(view, first, end);
        }
    }
    end_walk(view);
}

// Visits an invocation's texels with a caster of any kind whose curves are made by two walks.

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
