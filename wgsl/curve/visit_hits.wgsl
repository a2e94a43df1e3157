// Visits the four texels with a caster of any kind; every hit is inserted into its curve at once, or, with
// order-dependent blending, after those in front of it.

import package::curve::gather::{
    corner, join, join_ramp, must_flush, opaque_depth, open_added, open_end, scale, see,
};
import package::curve::light4::{Light4, black4, light4, plus, scaled, selected};
import package::curve::volumes::{change_density, crossed, last_face, surface_light, surface_scale};
import package::features::{HAS_OVER, HAS_PUFFS, HAS_VOLUMES, ROLLED};
import package::hit::caster_hit::{Hit, MISS, caster_hit};
import package::hit::crossing::{Face, face_crossing, volume_face};
import package::hit::hit_order::{Hit4, WAITING, hits_of, next_waiting, pass_on};
import package::records::footprint::Footprint;
import package::records::footprint_loaded::load_footprint;
import package::records::view::GpuView;
import package::traversal::candidate::Offer;
import package::traversal::kinds::visited;

fn ordered() -> bool {
    return false;
}

fn blocked() -> bool {
    return true;
}

fn slabbed() -> bool {
    return false;
}

fn count_hits(view: GpuView, footprint: Footprint) {}

fn count_lane(view: GpuView, offer: Offer, lane: u32) {}

fn hit_texel(view: GpuView, footprint: Footprint, i: u32) -> Hit {
    let hit = caster_hit(view, footprint, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    if !(hit.depth >= 0.0 && hit.depth < opaque_depth[i]) {
        return MISS;
    }
    return hit;
}

fn face_texel(view: GpuView, footprint: Footprint, i: u32) -> Face {
    let face = volume_face(view, footprint, corner + vec2(0.5, f32(i) + 0.5), opaque_depth[i]);
    crossed[i] += face_crossing(face);
    return face;
}

fn density_change(face: Face) -> vec3<f32> {
    return face.metres * face.absorption * f32(-face.leaves);
}

fn cross_faces(view: GpuView, footprint: Footprint) -> vec4<bool> {
    let a = face_texel(view, footprint, 0u);
    let b = face_texel(view, footprint, 1u);
    let c = face_texel(view, footprint, 2u);
    let d = face_texel(view, footprint, 3u);
    let meets = vec4(a.leaves, b.leaves, c.leaves, d.leaves) != vec4(0);
    // A texel without a face gets a zero change at its last face.
    let depth = select(last_face, vec4(a.depth, b.depth, c.depth, d.depth), meets);
    let change = light4(density_change(a), density_change(b), density_change(c), density_change(d));
    return join_ramp(change_density(depth, selected(black4(), change, meets)));
}

// Returns true if the hits must be inserted at once.
fn visit(view: GpuView, footprint: Footprint) -> bool {
    var ramps = vec4(false);
    if HAS_VOLUMES {
        ramps = cross_faces(view, footprint);
    }
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
    let came = hits_of(met);
    see(came.depth, came.opacity);
    if HAS_OVER {
        return must_flush(ramps | join_hits(pass_on(came), black4()));
    }
    let absorbed = light4(met[0].absorbed, met[1].absorbed, met[2].absorbed, met[3].absorbed);
    return must_flush(ramps | join_hits(came, absorbed));
}

// Visits the candidate of lane `lane`. Returns true if some lane's hits must be inserted at once.
fn visit_lane(view: GpuView, offer: Offer, lane: u32, is_triangle: bool) -> bool {
    let footprint = load_footprint(subgroupShuffle(offer, lane));
    return subgroupAny(visit(view, visited(footprint, is_triangle)));
}

// `absorbed` is not read with `over`.
fn join_hits(hits: Hit4, absorbed: Light4) -> vec4<bool> {
    let placed = join(hits.light, absorbed, hits.depth, hits.opacity);
    if HAS_PUFFS {
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

// Hits that wait in order are joined behind all pairs, one of each texel at a time.
fn waiting_steps() -> u32 {
    return select(0u, WAITING, HAS_OVER);
}

fn join_waiting() {
    let placed = join_hits(next_waiting(), black4());
}
