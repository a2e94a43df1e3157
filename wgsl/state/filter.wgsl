// The state of four texels while their casters are multiplied up, front to back, in registers. CPU
// twin: src/reference/accumulate.rs.

import package::bind::sampled::opaques;
import package::features::{HAS_GAIN, HAS_OVER, HAS_OWNERS, HAS_TRIANGLES, HAS_VOLUMES, ROLLED};
import package::hit::caster_hit::caster_hit;
import package::hit::crossing::{added_light, crossing};
import package::records::caster::particle_object;
import package::records::owner::{NO_OWNER, owner_tag};
import package::records::record::TRIANGLE_BIT;
import package::records::setup::setup_texel;
import package::records::view::GpuView;
import package::sums::sums::{BLACK, VISIBLE_OPACITY, light};

const ROWS: u32 = 4u; // texels that an invocation holds, in a column

var<private> corner: vec2<f32>;             // first of the four texels, in the view's map
var<private> passed: array<vec3<f32>, 4>;   // transmittance so far
var<private> added: array<vec3<f32>, 4>;    // by `over`
var<private> crossed: array<vec4<i32>, 4>;  // of volumes: optical depth and what is left
var<private> nearest: vec4<f32>;
var<private> owner: vec4<u32>;              // whose the nearest is
var<private> opaque_depth: vec4<f32>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest = vec4(1.0);
    owner = vec4(NO_OWNER);
    for (var i = 0u; i < 4u; i += 1u) {
        passed[i] = vec3(1.0);
        added[i] = vec3(0.0);
        crossed[i] = vec4(0);
        opaque_depth[i] = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
    }
}

fn visit_texel(view: GpuView, place: vec4<u32>, look: vec4<u32>, i: u32) {
    let texel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = caster_hit(view, place, look, texel, opaque_depth[i]);
    if HAS_VOLUMES {
        crossed[i] += crossing(view, look, texel, opaque_depth[i]);
    }
    let counts = hit.depth >= 0.0 && hit.depth < opaque_depth[i];
    passed[i] *= select(vec3(1.0), hit.light, counts);
    if HAS_OVER {
        added[i] = select(added[i], added[i] * hit.light + added_light(hit), counts);
    }
    let seen = counts && hit.opacity >= VISIBLE_OPACITY;
    if HAS_OWNERS && seen && hit.depth < nearest[i] {
        owner[i] = owner_of(look);
    }
    nearest[i] = select(nearest[i], min(nearest[i], hit.depth), seen);
}

fn owner_of(look: vec4<u32>) -> u32 {
    if HAS_TRIANGLES && (look.w & TRIANGLE_BIT) != 0u {
        return owner_tag(setup_texel(look.x, 6u).w);
    }
    return owner_tag(particle_object(look.w));
}

fn owner_texel(i: u32) -> u32 {
    return owner[i];
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

fn nearest_texel(i: u32) -> f32 {
    // 0 where the light is inside a volume.
    return select(nearest[i], 0.0, HAS_VOLUMES && crossed[i].w > 0);
}

fn passed_texel(i: u32) -> vec3<f32> {
    if HAS_OVER || HAS_VOLUMES {
        // A body that is not closed would brighten.
        let tau = max(crossed[i].xyz, vec3(0));
        return (passed[i] + added[i]) * light(bitcast<vec3<u32>>(tau));
    }
    return passed[i];
}

// Nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    if HAS_VOLUMES {
        return false;
    }
    var open = false;
    for (var i = 0u; i < 4u; i += 1u) {
        let lit = HAS_GAIN || HAS_OVER || any(passed[i] >= vec3(BLACK)) || nearest[i] > front;
        open = open || (lit && opaque_depth[i] > front);
    }
    return !open;
}
