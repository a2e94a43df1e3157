// A caster of a lane, of any kind: the lane broadcasts its id, and all load its footprint.

import package::features::{
    HAS_BRICKS, HAS_CAPSULES, HAS_GAUSSIANS, HAS_PARTICLES, HAS_PUFFS, HAS_QUADS, HAS_TRIANGLES, KINDS_APART,
    only_capsules, only_gaussians,
};
import package::hit::capsule::{capsule_half, capsule_touches};
import package::hit::gaussian::gaussian_touches;
import package::records::caster::{gaussian_setup, is_capsule, is_gaussian};
import package::records::footprint::{Footprint, load_footprint};
import package::records::tile::SLACK;
import package::records::view::{GpuView, is_beside};
import package::traversal::lane::shared_index;
import choice::accumulator::visit;

struct LaneCaster {
    id: u32,
    footprint: Footprint,
}

alias Payload = u32;

fn lane_caster_of(id: u32, footprint: Footprint) -> LaneCaster {
    return LaneCaster(id, footprint);
}

// Whether the caster may touch texel centres in the box lo..hi.
fn touches(view: GpuView, caster: LaneCaster, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return touches_box(view, caster.footprint, lo, hi);
}

// Payload that the lane broadcasts; `front`: lower bound of the caster's depth.
fn payload_of(view: GpuView, caster: LaneCaster, front: f32) -> Payload {
    return caster.id;
}

// Visits the caster of lane `lane`. `is_triangle`: kind of the loop.
fn visit_lane(view: GpuView, payload: Payload, lane: u32, is_triangle: bool) {
    let id = shared_index(subgroupShuffle(payload, lane));
    visit(view, id, visited(load_footprint(id), is_triangle));
}

// Whether a footprint may touch texel centres in the box lo..hi.
fn touches_box(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let center = footprint.bounds.xy;
    let radius = footprint.bounds.z;
    if is_beside(footprint.bounds) {
        return true;
    }
    let outside = center - clamp(center, lo, hi);
    if HAS_TRIANGLES && footprint.is_triangle {
        return max(abs(outside.x), abs(outside.y)) <= radius;
    }
    if HAS_CAPSULES && (only_capsules() || is_capsule(footprint)) {
        return capsule_touches(footprint.bounds, capsule_half(footprint.look), lo, hi);
    }
    if HAS_GAUSSIANS && (only_gaussians() || is_gaussian(footprint)) {
        return gaussian_touches(view, gaussian_setup(footprint), footprint.bounds, lo, hi);
    }
    var reach = radius * select(1.0, 1.41421356, HAS_QUADS);
    if view.perspective > 0.0 {
        if HAS_PUFFS || HAS_BRICKS {
            // A sphere's cone has its radius over distance as sine, not as tangent.
            reach = select(1e30, reach / sqrt(1.0 - reach * reach), reach < 1.0);
        }
        // tan(axis + cone) - tan(axis), outwards from the view's centre.
        let slope = length(center - view.size * 0.5) / view.scale;
        let rest = 1.0 - slope * reach;
        reach = select(1e30, view.scale * reach * (1.0 + slope * slope) / rest, rest > 0.0);
    }
    reach += SLACK;
    return dot(outside, outside) <= reach * reach;
}

// Walks that visit particles and triangles in loops of their own. Drivers of software adapters take both
// sides of branches, but they leave loops, though only at their end, so the loops of walks test there whether
// to go on. Elsewhere a branch costs nothing, as all lanes visit the same caster, and a second loop doubles
// the code.

// Whether there are two loops: one of particles, one of triangles.
fn kinds_apart() -> bool {
    return KINDS_APART && HAS_PARTICLES && HAS_TRIANGLES;
}

// Footprint that a loop visits. Where the loop has only one kind, the compiler drops the code for the other.
fn visited(footprint: Footprint, is_triangle: bool) -> Footprint {
    let known = KINDS_APART || !(HAS_PARTICLES && HAS_TRIANGLES);
    return Footprint(
        footprint.bounds,
        footprint.look,
        select(footprint.is_triangle, is_triangle, known),
    );
}
