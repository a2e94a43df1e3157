// Accumulator: transmittance and nearest depth of an invocation's texels, front to back, in registers. CPU
// reference: crates/gobo-reference/src/accumulate.rs.

import package::bind::changed::counters;
import package::bind::sampled::opaques;
import package::features::{FAINT, HAS_GAIN, HAS_OVER, HAS_OWNERS, HAS_VOLUMES, unrolled};
import package::hit::caster_hit::{Faced, faced_hit, set_up};
import package::hit::crossing::crossing;
import package::hit::hit::{Hit, MISS, presence_of};
import package::hit::hit_order::{
    OrderedHit, WAITING, depths_of_keys, late_hits, least_depth, ordered_hit, pass_on,
};
import package::records::caster::object_of;
import package::records::footprint::Footprint;
import package::records::texel::{Found, NO_OWNER, owner_tag};
import package::records::view::GpuView;
import package::sums::sums::{BLACK, VISIBLE_PRESENCE, keep, light};
import choice::rows::ROW_COUNT;
import choice::waiting::{clear_waiting, take_hit};

const ROWS: u32 = ROW_COUNT; // texels that an invocation holds, in a column

struct Texel {
    passed: vec3<f32>, // transmittance so far
    lost: vec3<f32>,   // absorbed by faint casters, not yet in `passed`
    added: vec3<f32>,  // by `over`
    crossed: vec4<i32>, // volumes: optical depth, and faces left minus entered
    nearest: f32,      // light depths: of the nearest visible hit, and of the opaque surface
    opaque: f32,
    owner: u32,        // owner tag of the nearest hit
    // With order-dependent blending:
    keys: vec2<f32>,   // light depths of depth keys 0 and 1
    begin: f32,        // light depths between which hits belong to this part of the walk
    before: f32,
    last_left: f32,    // light depth of the last hit that left the buffer
}

var<private> corner: vec2<f32>; // first of the texels, in the view's map
var<private> texels: array<Texel, ROWS>;
var<private> found: array<Found, ROWS>;
var<private> body_faces: bool; // whether faces of volumes belong to this part of the walk

fn start(view: GpuView, texel: vec2<u32>) {
    corner = vec2<f32>(texel);
    body_faces = true;
    late_hits = 0u;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        texels[i] = Texel();
        texels[i].passed = vec3(1.0);
        texels[i].nearest = 1.0;
        texels[i].owner = NO_OWNER;
        texels[i].opaque = textureLoad(opaques, view.origin + texel + vec2(0u, i), view.layer, 0).r;
        if HAS_OVER {
            texels[i].keys = depths_of_keys(view, corner + vec2(0.5, f32(i) + 0.5));
            texels[i].begin = -1.0;
            texels[i].before = 2.0;
            texels[i].last_left = -1.0;
            clear_waiting(i);
        }
    }
}

// Hit in front of the opaque surface.
fn hit_texel(
    view: GpuView,
    footprint: Footprint,
    faced: Faced,
    t: ptr<function, Texel>,
    at: vec2<f32>,
) -> Hit {
    let hit = faced_hit(view, footprint, faced, at, (*t).opaque);
    var counts = hit.depth >= 0.0 && hit.depth < (*t).opaque;
    if HAS_OVER {
        counts = counts && hit.depth >= (*t).begin && hit.depth < (*t).before;
    }
    let seen = counts && presence_of(hit) >= VISIBLE_PRESENCE;
    if HAS_OWNERS && seen && hit.depth < (*t).nearest {
        (*t).owner = owner_tag(object_of(footprint));
    }
    (*t).nearest = select((*t).nearest, min((*t).nearest, hit.depth), seen);
    if !counts {
        return MISS;
    }
    return hit;
}

fn visit(view: GpuView, id: u32, footprint: Footprint) {
    let faced = set_up(view, footprint);
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let at = corner + vec2(0.5, f32(i) + 0.5);
        var texel = texels[i];
        if HAS_VOLUMES && body_faces {
            texel.crossed += crossing(view, footprint, at, texel.opaque);
        }
        let hit = hit_texel(view, footprint, faced, &texel, at);
        if HAS_OVER {
            compose(&texel, pass_on(i, ordered_hit(hit), texel.last_left));
        } else if FAINT {
            let kept = keep(texel.passed, texel.lost, hit.absorbed);
            texel.passed = kept.passed;
            texel.lost = kept.lost;
        } else {
            texel.passed *= hit.light;
        }
        texels[i] = texel;
    }
}

// Adds a hit that has left the buffer.
fn compose(t: ptr<function, Texel>, left: OrderedHit) {
    (*t).passed *= left.light;
    (*t).added = (*t).added * left.light + left.added;
    (*t).last_left = max((*t).last_left, left.depth);
}

// Composes the hits that still wait, behind all that were visited.
fn finish() {
    if HAS_OVER {
        for (var turn = 0u; turn < WAITING; turn += 1u) {
            for (var i = 0u; i < unrolled(ROWS); i += 1u) {
                var texel = texels[i];
                compose(&texel, take_hit(i));
                texels[i] = texel;
            }
        }
        if late_hits > 0u {
            atomicAdd(&counters.disordered, late_hits);
        }
    }
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        if FAINT && !HAS_OVER {
            texels[i].passed *= 1.0 - texels[i].lost;
        }
        var through = texels[i].passed;
        if HAS_OVER || HAS_VOLUMES {
            // A mesh that is not closed would brighten.
            let tau = max(texels[i].crossed.xyz, vec3(0));
            through = (through + texels[i].added) * light(bitcast<vec3<u32>>(tau));
        }
        // 0 if the light is inside a volume.
        let inside = HAS_VOLUMES && texels[i].crossed.w > 0;
        found[i] = Found(through, select(texels[i].nearest, 0.0, inside), texels[i].owner);
    }
}

// Whether nothing at or behind `front` can change these texels.
fn settled(front: f32) -> bool {
    if HAS_VOLUMES {
        return false;
    }
    var open = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        let depth = least_depth(texels[i].keys, front);
        let lit = HAS_GAIN || HAS_OVER || any(texels[i].passed >= vec3(BLACK)) || texels[i].nearest > depth;
        open = open || (lit && texels[i].opaque > depth);
    }
    return !open;
}
