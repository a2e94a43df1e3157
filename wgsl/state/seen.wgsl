// The nearest solid caster of four pixels. CPU twin: src/reference/shade/mod.rs.

import package::features::ROLLED;
import package::hit::caster_hit::caster_hit;
import package::hit::solid::is_solid;
import package::records::view::GpuView;
import package::shade::cost::count_pair;

var<private> corner: vec2<f32>; // first of the four pixels
var<private> nearest: vec4<f32>;
var<private> seen: vec4<u32>;   // caster
var<private> setup_of: vec4<u32>;

fn start(view: GpuView, pixel: vec2<u32>) {
    corner = vec2<f32>(pixel);
    nearest = vec4(1.0);
    seen = vec4(0u);
    setup_of = vec4(0u);
}

fn visit_pixel(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) {
    let hit = caster_hit(view, place, look, corner + vec2(0.5, f32(i) + 0.5), 1.0);
    let nearer = is_solid(hit) && hit.depth < nearest[i];
    nearest[i] = select(nearest[i], hit.depth, nearer);
    seen[i] = select(seen[i], look.w, nearer);
    setup_of[i] = select(setup_of[i], look.x, nearer);
}

fn visit(view: GpuView, footprint: u32, place: vec4<u32>, look: vec4<u32>) {
    count_pair();
    for (var i = 0u; ROLLED && i < 4u; i += 1u) {
        visit_pixel(view, place, look, i);
    }
    if !ROLLED {
        visit_pixel(view, place, look, 0u);
        visit_pixel(view, place, look, 1u);
        visit_pixel(view, place, look, 2u);
        visit_pixel(view, place, look, 3u);
    }
}

fn settled(front: f32) -> bool {
    return all(nearest <= vec4(front));
}
