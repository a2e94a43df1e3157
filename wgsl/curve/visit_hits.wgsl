// Visits an invocation's texels with a caster of any kind. Each hit is inserted into its curve at once or,
// with order-dependent blending or volumes, after the hits in front of it.

import package::bind::uniform::materials;
import package::curve::gather::{
    TRACE, corner, join, join_ramp, must_flush, opaque_depth, open_added, open_end, scale, see,
};
import package::curve::lights::{Lights, black, difference, plus, scaled, with_light};
import package::curve::overflow::is_light;
import package::curve::volumes::{change_density, crossed, surface_light, surface_scale};
import package::features::{HAS_BRICKS, HAS_CAPSULES, HAS_MEDIA, HAS_OVER, HAS_PUFFS, HAS_VOLUMES, unrolled};
import package::hit::brick::{ramp_count, ramp_index, ramps_of};
import package::hit::caster_hit::{Faced, faced_hit, set_up};
import package::hit::crossing::{face_crossing, volume_face};
import package::hit::hit::{Hit, MISS};
import package::hit::hit_order::{Hits, WAITING, delayed, no_hits, pass_on, with_hit};
import package::records::brick::brick_of;
import package::records::caster::particle_object;
import package::records::footprint::{Footprint, caster_of, load_footprint};
import package::records::material::SHAPE_BRICK;
import package::records::view::GpuView;
import package::traversal::lane::shared_index;
import package::traversal::lane_caster::{Payload, visited};
import choice::rows::{ROW_COUNT, RowIs, Rows, any_row, row, with_row};
import choice::waiting::take_hits;

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

fn hit_texel(view: GpuView, footprint: Footprint, faced: Faced, i: u32) -> Hit {
    let opaque = row(opaque_depth, i);
    let hit = faced_hit(view, footprint, faced, corner + vec2(0.5, f32(i) + 0.5), opaque);
    if !(hit.depth >= 0.0 && hit.depth < opaque) {
        return MISS;
    }
    return hit;
}

// `came`, with the faces of volumes.
fn with_faces(came: Hits, view: GpuView, footprint: Footprint) -> Hits {
    var all = came;
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let face = volume_face(view, footprint, corner + vec2(0.5, f32(i) + 0.5), row(opaque_depth, i));
        crossed[i] += face_crossing(face);
        let absorbed = face.metres * face.absorption * f32(-face.leaves);
        all.depth = with_row(all.depth, i, select(face.depth, row(all.depth, i), face.leaves == 0));
        all.change = with_light(all.change, i, select(absorbed, vec3(0.0), face.leaves == 0));
    }
    return all;
}

// Returns true if the hits must be inserted at once. A brick is visited once per ramp. The previous caster's
// delayed hits are joined first, and so need no registers meanwhile.
fn visit(view: GpuView, footprint: Footprint) -> bool {
    join_delayed();
    let faced = set_up(view, footprint);
    open_ramp(footprint, faced);
    var came = no_hits();
    var absorbed = black();
    var starts = came.depth;
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let hit = hit_texel(view, footprint, faced, i);
        came = with_hit(came, i, hit);
        starts = with_row(starts, i, hit.start);
        absorbed = with_light(absorbed, i, hit.absorbed);
    }
    close_ramp();
    see(came.depth, came.presence);
    came.depth = starts;
    if HAS_VOLUMES {
        return delay(pass_on(with_faces(came, view, footprint)));
    }
    if HAS_OVER {
        came = pass_on(came);
    }
    return must_flush(join_hits(came, absorbed));
}

// Continues the volumes to hits, which are joined behind the volumes' ramps. Returns true if these ramps must
// be inserted.
fn delay(hits: Hits) -> bool {
    delayed = hits;
    // A clear surface of a volume takes no node.
    let acts = is_light(hits.light) | (difference(hits.added, black()) > Rows(0.0));
    delayed.presence = select(Rows(0.0), hits.presence, acts);
    let ramps = join_ramp(change_density(hits.depth, hits.change));
    return any_row(ramps | (delayed.presence >= Rows(TRACE)));
}

// Joins the hits behind volumes' ramps.
fn join_delayed() {
    if HAS_VOLUMES {
        let placed = join_hits(delayed, black());
        delayed = no_hits();
    }
}

// Visits the caster of lane `lane`. Returns true if some lane's hits must be inserted at once.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) -> bool {
    let footprint = load_footprint(shared_index(subgroupShuffle(payload, lane)));
    return subgroupAny(visit(view, visited(footprint, is_triangle)));
}

// `absorbed` is not read with `over` or volumes.
fn join_hits(hits: Hits, absorbed: Lights) -> RowIs {
    let placed = join(hits.light, absorbed, hits.depth, hits.presence);
    if HAS_PUFFS || HAS_MEDIA || HAS_BRICKS || HAS_CAPSULES {
        open_end = select(open_end, max(open_end, hits.end), placed);
    }
    if HAS_OVER || HAS_VOLUMES {
        scale = scaled(scale, hits.light);
        surface_light = scaled(surface_light, hits.light);
        surface_scale = scaled(surface_scale, hits.light);
    }
    if HAS_OVER {
        open_added = plus(scaled(open_added, hits.light), hits.added);
        surface_light = plus(surface_light, hits.added);
    }
    return placed;
}

// Steps for hits that wait in order: they are joined behind all pairs, one of each texel at a time.
fn waiting_steps() -> u32 {
    return select(0u, WAITING, HAS_OVER || HAS_VOLUMES);
}

fn join_waiting() {
    if HAS_VOLUMES {
        join_delayed();
        let ramps = delay(take_hits());
    } else {
        let placed = join_hits(take_hits(), black());
    }
}
