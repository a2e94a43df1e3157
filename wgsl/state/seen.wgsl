// The nearest solid caster of a pixel. CPU twin: src/cpu/shade/mod.rs.

import package::hit::caster_hit::caster_hit;
import package::hit::solid::is_solid;
import package::records::view::GpuView;
import package::shade::cost::count_pair;

const ROWS: u32 = 1u; // pixels that an invocation holds

var<private> corner: vec2<f32>; // of the pixel
var<private> nearest: f32;
var<private> seen: u32;         // caster
var<private> setup_of: u32;

fn start(pixel: vec2<u32>) {
    corner = vec2<f32>(pixel);
    nearest = 1.0;
    seen = 0u;
    setup_of = 0u;
}

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    count_pair();
    let hit = caster_hit(view, place, look, corner + 0.5, 1.0);
    let nearer = is_solid(hit) && hit.depth < nearest;
    nearest = select(nearest, hit.depth, nearer);
    seen = select(seen, look.w, nearer);
    setup_of = select(setup_of, look.x, nearer);
}

fn settled(front: f32) -> bool {
    return nearest <= front;
}
