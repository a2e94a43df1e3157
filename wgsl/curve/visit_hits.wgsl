// Visits an invocation's texels with a caster of any kind. Each hit is inserted into its curve at once or,
// with order-dependent blending or volumes, after the hits in front of it.

import package::bind::uniform::materials;
import package::curve::gather::{ROWS, TRACE, Texel, corner, join, join_ramp, texels};
import package::curve::volumes::change_density;
import package::features::{HAS_BRICKS, HAS_OVER, HAS_VOLUMES, unrolled};
import package::hit::brick::{ramp_count, ramp_index, ramps_of};
import package::hit::caster_hit::{Faced, faced_hit, set_up};
import package::hit::crossing::{face_crossing, volume_face};
import package::hit::hit::{Hit, MISS};
import package::hit::hit_order::{NO_HIT, OrderedHit, WAITING, ordered_hit, pass_on};
import package::records::brick::brick_of;
import package::records::caster::particle_object;
import package::records::footprint::{Footprint, caster_of, load_footprint};
import package::records::material::SHAPE_BRICK;
import package::records::view::GpuView;
import package::sums::sums::VISIBLE_PRESENCE;
import package::traversal::lane::shared_index;
import package::traversal::lane_caster::{Payload, visited};
import choice::waiting::take_hit;

// Whether the caster was visited for all of its ramps.
fn is_whole() -> bool {
    return !HAS_BRICKS || ramp_index == 0u;
}

fn open_ramp(footprint: Footprint, faced: Faced) {
    ramp_count = 0u;
    if HAS_BRICKS && !footprint.is_triangle && materials[faced.look & 0xffffu].shape == SHAPE_BRICK {
        ramp_count = ramps_of(brick_of(particle_object(caster_of(footprint))));
    }
}

fn close_ramp() {
    ramp_index = select(0u, ramp_index + 1u, ramp_index + 1u < ramp_count);
    ramp_count = 0u;
}

fn hit_texel(view: GpuView, footprint: Footprint, faced: Faced, at: vec2<f32>, opaque: f32) -> Hit {
    let hit = faced_hit(view, footprint, faced, at, opaque);
    if !(hit.depth >= 0.0 && hit.depth < opaque) {
        return MISS;
    }
    return hit;
}

// `came`, with the face of a volume.
fn with_face(
    came: OrderedHit,
    view: GpuView,
    footprint: Footprint,
    t: ptr<function, Texel>,
    at: vec2<f32>,
) -> OrderedHit {
    let face = volume_face(view, footprint, at, (*t).opaque);
    (*t).crossed += face_crossing(face);
    let absorbed = face.metres * face.absorption * f32(-face.leaves);
    var both = came;
    both.depth = select(face.depth, came.depth, face.leaves == 0);
    both.change = select(absorbed, vec3(0.0), face.leaves == 0);
    return both;
}

// Returns whether the hits must be inserted at once. A brick is visited once per ramp. The previous caster's
// delayed hit is joined first, and so needs no registers meanwhile.
fn visit(view: GpuView, footprint: Footprint) -> bool {
    let faced = set_up(view, footprint);
    open_ramp(footprint, faced);
    var placed = false;
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        join_delayed(&texel);
        let at = corner + vec2(0.5, f32(i) + 0.5);
        let hit = hit_texel(view, footprint, faced, at, texel.opaque);
        var came = ordered_hit(hit);
        let sees = (came.presence >= VISIBLE_PRESENCE) & (came.depth < texel.nearest);
        texel.nearest = select(texel.nearest, came.depth, sees);
        came.depth = hit.start;
        if HAS_VOLUMES {
            came = with_face(came, view, footprint, &texel, at);
        }
        if HAS_OVER || HAS_VOLUMES {
            came = leave_order(&texel, i, came);
        }
        if HAS_VOLUMES {
            placed = delay(&texel, came) | placed;
        } else {
            placed = join(&texel, came, hit.absorbed) | placed;
        }
        texels[i] = texel;
    }
    close_ramp();
    return placed;
}

// The hit that leaves the order in exchange for the one that came.
fn leave_order(t: ptr<function, Texel>, i: u32, came: OrderedHit) -> OrderedHit {
    let left = pass_on(i, came, (*t).last_left);
    (*t).last_left = max((*t).last_left, left.depth);
    return left;
}

// Continues the volumes to a hit, which is joined behind the volumes' ramp. Returns whether the ramp or the
// hit must be inserted.
fn delay(t: ptr<function, Texel>, hit: OrderedHit) -> bool {
    (*t).delayed = hit;
    // A clear surface of a volume takes no node.
    let acts = any(hit.light != vec3(1.0)) | any(hit.added != vec3(0.0));
    (*t).delayed.presence = select(0.0, hit.presence, acts);
    let is_ramp = join_ramp(t, change_density(t, hit.depth, hit.change));
    return is_ramp | ((*t).delayed.presence >= TRACE);
}

// Joins the hit behind the volumes' ramp.
fn join_delayed(t: ptr<function, Texel>) {
    if HAS_VOLUMES {
        let placed = join(t, (*t).delayed, vec3(0.0));
        (*t).delayed = NO_HIT;
    }
}

// Visits the caster of lane `lane`. Returns true if some lane's hits must be inserted at once.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) -> bool {
    let footprint = load_footprint(shared_index(subgroupShuffle(payload, lane)));
    return subgroupAny(visit(view, visited(footprint, is_triangle)));
}

// Steps for hits that wait in order: they are joined behind all pairs, one of each texel at a time.
fn waiting_steps() -> u32 {
    return select(0u, WAITING, HAS_OVER || HAS_VOLUMES);
}

fn join_waiting() {
    for (var i = 0u; i < unrolled(ROWS); i += 1u) {
        var texel = texels[i];
        if HAS_VOLUMES {
            join_delayed(&texel);
            let placed = delay(&texel, take_hit(i));
        } else {
            let placed = join(&texel, take_hit(i), vec3(0.0));
        }
        texels[i] = texel;
    }
}
