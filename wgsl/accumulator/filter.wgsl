// Accumulator: transmittance and nearest depth of an invocation's texels, front to back, in registers. CPU
// reference: crates/gobo-reference/src/accumulate.rs.

import package::bind::changed::counters;
import package::bind::sampled::opaques;
import package::curve::lights::{Lights, black, light_row, plus, scaled, white};
import package::features::{FAINT, HAS_GAIN, HAS_OVER, HAS_OWNERS, HAS_VOLUMES, unrolled};
import package::hit::caster_hit::{Faced, faced_hit, set_up};
import package::hit::crossing::crossing;
import package::hit::hit::{Hit, MISS, presence_of};
import package::hit::hit_order::{
    Hits, WAITING, clear_order, front_depths, late_hits, no_hits, pass_on, start_keys, with_hit,
};
import package::records::caster::object_of;
import package::records::footprint::Footprint;
import package::records::texel::{Found, NO_OWNER, owner_tag};
import package::records::view::GpuView;
import package::sums::sums::{BLACK, VISIBLE_PRESENCE, keep, light};
import choice::rows::{ROW_COUNT, RowBits, Rows, any_row, row, row_bits, with_bits, with_row};
import choice::waiting::take_hits;

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> passed: array<vec3<f32>, ROW_COUNT>; // transmittance so far
var<private> lost: array<vec3<f32>, ROW_COUNT>;   // absorbed by faint casters, not yet in `passed`
var<private> passed_in_order: Lights; // order-dependent blending: scale, and added light
var<private> added_in_order: Lights;
var<private> body_from: Rows;          // light depths between which hits belong to this part of the walk
var<private> body_before: Rows;
var<private> body_faces: bool;
var<private> crossed: array<vec4<i32>, ROW_COUNT>; // volumes: optical depth, and faces left minus entered
var<private> nearest: Rows;
var<private> owner: RowBits; // owner tag of the nearest hit
var<private> opaque_depth: Rows;
var<private> added: array<vec3<f32>, ROW_COUNT>; // by `over`, once the walk is finished
var<private> found: array<Found, ROW_COUNT>;

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    nearest = Rows(1.0);
    owner = RowBits(NO_OWNER);
    passed_in_order = white();
    added_in_order = black();
    body_from = Rows(-1.0);
    body_before = Rows(2.0);
    body_faces = true;
    clear_order();
    start_keys(view, corner);
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        passed[i] = vec3(1.0);
        lost[i] = vec3(0.0);
        crossed[i] = vec4(0);
        let at = view.origin + texel + vec2(0u, i);
        opaque_depth = with_row(opaque_depth, i, textureLoad(opaques, at, view.layer, 0).r);
    }
}

// Hit in front of the opaque surface.
fn hit_texel(view: GpuView, footprint: Footprint, faced: Faced, i: u32) -> Hit {
    let texel = corner + vec2(0.5, f32(i) + 0.5);
    let opaque = row(opaque_depth, i);
    let hit = faced_hit(view, footprint, faced, texel, opaque);
    var counts = hit.depth >= 0.0 && hit.depth < opaque;
    if HAS_OVER {
        counts = counts && hit.depth >= row(body_from, i) && hit.depth < row(body_before, i);
    }
    let seen = counts && presence_of(hit) >= VISIBLE_PRESENCE;
    let before = row(nearest, i);
    if HAS_OWNERS && seen && hit.depth < before {
        owner = with_bits(owner, i, owner_tag(object_of(footprint)));
    }
    nearest = with_row(nearest, i, select(before, min(before, hit.depth), seen));
    if !counts {
        return MISS;
    }
    return hit;
}

// Adds the faces of volumes.
fn cross_faces(view: GpuView, footprint: Footprint) {
    if HAS_VOLUMES && body_faces {
        for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
            let texel = corner + vec2(0.5, f32(i) + 0.5);
            crossed[i] += crossing(view, footprint, texel, row(opaque_depth, i));
        }
    }
}

fn visit_in_order(view: GpuView, footprint: Footprint, faced: Faced) {
    var came = no_hits();
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        came = with_hit(came, i, hit_texel(view, footprint, faced, i));
    }
    compose(pass_on(came));
}

fn compose(hits: Hits) {
    passed_in_order = scaled(passed_in_order, hits.light);
    added_in_order = plus(scaled(added_in_order, hits.light), hits.added);
}

// Composes the hits that still wait, behind all that were visited.
fn finish() {
    if HAS_OVER {
        for (var i = 0u; i < WAITING; i += 1u) {
            compose(take_hits());
        }
        if late_hits > 0u {
            atomicAdd(&counters.disordered, late_hits);
        }
    }
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        if HAS_OVER {
            passed[i] = light_row(passed_in_order, i);
            added[i] = light_row(added_in_order, i);
        } else if FAINT {
            passed[i] *= 1.0 - lost[i];
        }
        var through = passed[i];
        if HAS_OVER || HAS_VOLUMES {
            // A mesh that is not closed would brighten.
            let tau = max(crossed[i].xyz, vec3(0));
            through = (through + added[i]) * light(bitcast<vec3<u32>>(tau));
        }
        // 0 if the light is inside a volume.
        let inside = HAS_VOLUMES && crossed[i].w > 0;
        found[i] = Found(through, select(row(nearest, i), 0.0, inside), row_bits(owner, i));
    }
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    let faced = set_up(view, footprint);
    cross_faces(view, footprint);
    if HAS_OVER {
        visit_in_order(view, footprint, faced);
        return;
    }
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let hit = hit_texel(view, footprint, faced, i);
        if FAINT {
            let kept = keep(passed[i], lost[i], hit.absorbed);
            passed[i] = kept.passed;
            lost[i] = kept.lost;
        } else {
            passed[i] *= hit.light;
        }
    }
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    if HAS_VOLUMES {
        return false;
    }
    if HAS_OVER {
        return !any_row(opaque_depth > front_depths(front));
    }
    var open = false;
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let lit = HAS_GAIN || any(passed[i] >= vec3(BLACK)) || row(nearest, i) > front;
        open = open || (lit && row(opaque_depth, i) > front);
    }
    return !open;
}
