// Accumulator: the nearest opaque caster of a pixel. CPU reference: crates/gobo-reference/src/shade/mod.rs.

import package::features::HAS_TRIANGLES;
import package::hit::caster_hit::caster_hit;
import package::hit::coplanar::{COPLANAR, is_in_front};
import package::hit::hit::is_solid;
import package::records::footprint::{Footprint, caster_of, setup_of};
import package::records::view::GpuView;
import package::shade::camera::count_pair;

const ROWS: u32 = 1u; // pixels that an invocation holds

var<private> corner: vec2<f32>; // position of the pixel
var<private> nearest: f32;
var<private> seen: u32;         // caster
var<private> seen_setup: u32;

fn start(pixel: vec2<u32>) {
    corner = vec2<f32>(pixel);
    nearest = 1.0;
    seen = 0u;
    seen_setup = 0u;
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    count_pair();
    let hit = caster_hit(view, footprint, corner + 0.5, 1.0);
    let is_met = is_solid(hit) && hit.depth < 1.0;
    var nearer = is_met && hit.depth < nearest;
    if HAS_TRIANGLES && is_met && footprint.is_triangle {
        nearer = is_in_front(hit.depth, caster_of(footprint), nearest, seen);
    }
    nearest = select(nearest, hit.depth, nearer);
    seen = select(seen, caster_of(footprint), nearer);
    seen_setup = select(seen_setup, setup_of(footprint), nearer);
}

fn settled(front: f32) -> bool {
    return nearest + COPLANAR * nearest <= front;
}
