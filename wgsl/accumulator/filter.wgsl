// Accumulator: transmittance and nearest depth of four texels, front to back, in registers. CPU reference:
// src/reference/accumulate.rs.

import package::bind::changed::counters;
import package::bind::sampled::opaques;
import package::curve::light4::{Light4, black4, plus, scaled, white4};
import package::features::{FAINT, HAS_GAIN, HAS_OVER, HAS_OWNERS, HAS_VOLUMES, ROLLED};
import package::hit::caster_hit::{Hit, MISS, caster_hit};
import package::hit::crossing::crossing;
import package::hit::hit_order::{
    Hit4, WAITING, clear_order, hits_of, late_hits, next_waiting, pass_on,
};
import package::hit::key_depths::{front_depths, start_keys};
import package::hit::object::object_of;
import package::records::footprint::Footprint;
import package::records::owner::{NO_OWNER, owner_tag};
import package::records::view::GpuView;
import package::sums::faint::keep3;
import package::sums::sums::{BLACK, VISIBLE_OPACITY, light};

const ROWS: u32 = 4u; // texels that an invocation holds, in a column

var<private> corner: vec2<f32>;             // first of the four texels, in the view's map
var<private> passed: array<vec3<f32>, 4>;   // transmittance so far
var<private> lost: array<vec3<f32>, 4>;     // absorbed by faint casters, not yet multiplied into `passed`
var<private> passed_in_order: Light4;       // order-dependent blending: scale, and added light
var<private> added_in_order: Light4;
var<private> own_from: vec4<f32>;           // light depths between which hits belong to this part of the walk
var<private> own_before: vec4<f32>;
var<private> own_faces: bool;
var<private> crossed: array<vec4<i32>, 4>;  // volumes: optical depth, and faces left minus entered
var<private> nearest: vec4<f32>;
var<private> owner: vec4<u32>;              // owner tag of the nearest
var<private> opaque_depth: vec4<f32>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest = vec4(1.0);
    owner = vec4(NO_OWNER);
    passed_in_order = white4();
    added_in_order = black4();
    own_from = vec4(-1.0);
    own_before = vec4(2.0);
    own_faces = true;
    clear_order();
    start_keys(view, corner);
    for (var i = 0u; i < 4u; i += 1u) {
        passed[i] = vec3(1.0);
        lost[i] = vec3(0.0);
        crossed[i] = vec4(0);
        opaque_depth[i] = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
    }
}

// Hit in front of the opaque surface.
fn hit_texel(view: GpuView, footprint: Footprint, i: u32) -> Hit {
    let texel = corner + vec2(0.5, f32(i) + 0.5);
    let hit = caster_hit(view, footprint, texel, opaque_depth[i]);
    if HAS_VOLUMES && own_faces {
        crossed[i] += crossing(view, footprint, texel, opaque_depth[i]);
    }
    var counts = hit.depth >= 0.0 && hit.depth < opaque_depth[i];
    if HAS_OVER {
        counts = counts && hit.depth >= own_from[i] && hit.depth < own_before[i];
    }
    let seen = counts && hit.opacity >= VISIBLE_OPACITY;
    if HAS_OWNERS && seen && hit.depth < nearest[i] {
        owner[i] = owner_tag(object_of(footprint));
    }
    nearest[i] = select(nearest[i], min(nearest[i], hit.depth), seen);
    if !counts {
        return MISS;
    }
    return hit;
}

fn visit_texel(view: GpuView, footprint: Footprint, i: u32) {
    let hit = hit_texel(view, footprint, i);
    if FAINT {
        let kept = keep3(passed[i], lost[i], hit.absorbed);
        passed[i] = kept.passed;
        lost[i] = kept.lost;
    } else {
        passed[i] *= hit.light;
    }
}

fn visit_in_order(view: GpuView, footprint: Footprint) {
    var met = array(MISS, MISS, MISS, MISS);
    for (var i = 0u; ROLLED && i < 4u; i += 1u) {
        met[i] = hit_texel(view, footprint, i);
    }
    if !ROLLED {
        met[0] = hit_texel(view, footprint, 0u);
        met[1] = hit_texel(view, footprint, 1u);
        met[2] = hit_texel(view, footprint, 2u);
        met[3] = hit_texel(view, footprint, 3u);
    }
    compose(pass_on(hits_of(met)));
}

fn compose(hits: Hit4) {
    passed_in_order = scaled(passed_in_order, hits.light);
    added_in_order = plus(scaled(added_in_order, hits.light), hits.added);
}

// Composes the hits that still wait, behind all that were visited.
fn finish() {
    for (var i = 0u; FAINT && i < 4u; i += 1u) {
        passed[i] *= 1.0 - lost[i];
    }
    for (var i = 0u; HAS_OVER && i < WAITING; i += 1u) {
        compose(next_waiting());
    }
    for (var i = 0u; HAS_OVER && i < 4u; i += 1u) {
        passed[i] = vec3(passed_in_order.red[i], passed_in_order.green[i], passed_in_order.blue[i]);
    }
    if HAS_OVER && late_hits > 0u {
        atomicAdd(&counters.disordered, late_hits);
    }
}

fn added_texel(i: u32) -> vec3<f32> {
    if HAS_OVER {
        return vec3(added_in_order.red[i], added_in_order.green[i], added_in_order.blue[i]);
    }
    return vec3(0.0);
}

fn owner_texel(i: u32) -> u32 {
    return owner[i];
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    if HAS_OVER {
        visit_in_order(view, footprint);
        return;
    }
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
    // 0 if the light is inside a volume.
    return select(nearest[i], 0.0, HAS_VOLUMES && crossed[i].w > 0);
}

fn passed_texel(i: u32) -> vec3<f32> {
    if HAS_OVER || HAS_VOLUMES {
        // A mesh that is not closed would brighten.
        let tau = max(crossed[i].xyz, vec3(0));
        return (passed[i] + added_texel(i)) * light(bitcast<vec3<u32>>(tau));
    }
    return passed[i];
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    if HAS_VOLUMES {
        return false;
    }
    if HAS_OVER {
        return !any(opaque_depth > front_depths(front));
    }
    var open = false;
    for (var i = 0u; i < 4u; i += 1u) {
        let lit = HAS_GAIN || any(passed[i] >= vec3(BLACK)) || nearest[i] > front;
        open = open || (lit && opaque_depth[i] > front);
    }
    return !open;
}
