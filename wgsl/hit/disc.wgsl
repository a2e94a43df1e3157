// A soft disc of the `filter` transfer, set up for texels. CPU reference: crates/gobo-reference/src/hit.rs,
// crates/gobo-reference/src/puff.rs.

import package::bind::uniform::materials;
import package::features::{HAS_OPAQUE, PERSPECTIVE};
import package::hit::hit::{Hit, MISS, absorption, transmittance};
import package::records::footprint::{Footprint, opacity_slope};
import package::records::pack::unpack_absorbed;
import package::records::tile::SLACK;
import package::records::view::{GpuView, MIN_DISTANCE, is_beside};
import package::sums::sums::{tau_absorbed, whole_tau};

struct Disc {
    center: vec2<f32>,   // [texels]; for a disc beside the view the map's centre
    bend: f32,           // 1 / radius^2 [1 / texels^2]
    tilt: vec2<f32>,     // gradient of the plane's distance [1 / texels]
    tilt_bend: f32,
    start: vec2<f32>,    // (0, 1); for a disc beside the view the cosine of the axis, 0
    depth: f32,          // light depth; in a perspective view distance along the axis [m]
    slope: f32,          // opacity at the centre
    absorbed: vec3<f32>, // slope (1 - c)
}

fn prepare_disc(view: GpuView, footprint: Footprint) -> Disc {
    var disc: Disc;
    let bounds = footprint.bounds;
    let radius = bounds.z;
    disc.center = bounds.xy;
    disc.depth = bounds.w;
    // A hit at the end of the ray does nothing.
    disc.slope = select(opacity_slope(footprint), 0.0, !PERSPECTIVE && disc.depth >= 1.0);
    disc.absorbed = disc.slope * unpack_absorbed(footprint.look.xy);
    disc.bend = 1.0 / (radius * radius);
    if PERSPECTIVE {
        // q^2 = (|delta|^2 / scale^2 - (n . delta)^2) / (radius len t)^2, where n is the ray to
        // the centre, len its length at depth 1, t = 1 + tilt . delta.
        let slope = (disc.center - view.size * 0.5) / view.scale;
        let len2 = 1.0 + dot(slope, slope);
        disc.tilt = slope / (len2 * view.scale);
        disc.bend = 1.0 / (radius * radius * len2 * view.scale * view.scale);
        disc.tilt_bend = 1.0 / (radius * radius);
        disc.start = vec2(0.0, 1.0);
        disc.depth = view.near + disc.depth * (view.far - view.near);
        if is_beside(bounds) {
            // Delta from the map's centre: q^2 = (|ray|^2 - t^2) / (radius t)^2, t = n . ray.
            let center = bounds.xyw;
            let distance = max(length(center), MIN_DISTANCE);
            let n = center / distance;
            let per_radius = distance / radius;
            disc.center = view.size * 0.5;
            disc.tilt = n.xy / view.scale;
            disc.tilt_bend = per_radius * per_radius;
            disc.bend = disc.tilt_bend / (view.scale * view.scale);
            disc.start = vec2(n.z, 0.0);
            disc.depth = distance;
        }
    }
    return disc;
}

// The disc of lane `lane` of the subgroup.
fn broadcast_disc(disc: Disc, lane: u32) -> Disc {
    var other: Disc;
    other.center = subgroupShuffle(disc.center, lane);
    other.bend = subgroupShuffle(disc.bend, lane);
    other.depth = subgroupShuffle(disc.depth, lane);
    other.slope = subgroupShuffle(disc.slope, lane);
    other.absorbed = subgroupShuffle(disc.absorbed, lane);
    if PERSPECTIVE {
        other.tilt = subgroupShuffle(disc.tilt, lane);
        other.tilt_bend = subgroupShuffle(disc.tilt_bend, lane);
        other.start = subgroupShuffle(disc.start, lane);
    }
    return other;
}

// Whether a disc may touch a block of texels with centres from `lo` to `hi`.
fn disc_touches(view: GpuView, bounds: vec4<f32>, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let radius = bounds.z;
    let center = bounds.xy;
    if PERSPECTIVE && is_beside(bounds) {
        return true;
    }
    let outside = center - clamp(center, lo, hi);
    var reach = radius + SLACK;
    if PERSPECTIVE {
        // tan(axis + cone) - tan(axis), outwards from the view's centre.
        let slope = length((center - view.size * 0.5) / view.scale);
        let rest = 1.0 - slope * radius;
        reach = view.scale * radius * (1.0 + slope * slope) / rest + SLACK;
        reach = select(1e18, reach, rest > 0.0);
    }
    return dot(outside, outside) <= reach * reach;
}

// Opacity before the disc's slope, and light depth.
struct DiscHit {
    profile: f32,
    depth: f32,
}

// `delta`: from the disc's centre [texels].
fn disc_hit(view: GpuView, disc: Disc, delta: vec2<f32>, opaque: f32) -> DiscHit {
    let squared = delta.x * delta.x + delta.y * delta.y;
    if !PERSPECTIVE {
        let rest = max(1.0 - squared * disc.bend, 0.0);
        return DiscHit(select(0.0, rest * rest, !HAS_OPAQUE || disc.depth < opaque), disc.depth);
    }
    let turn = disc.start.x + (delta.x * disc.tilt.x + delta.y * disc.tilt.y);
    let t = disc.start.y + turn;
    let across = squared * disc.bend + ((1.0 - disc.start.y) - turn * turn) * disc.tilt_bend;
    let rest = max(1.0 - across / (t * t), 0.0);
    let depth = (disc.depth / t - view.near) / (view.far - view.near);
    let hits = t > 0.0 && depth >= 0.0 && depth < select(1.0, opaque, HAS_OPAQUE);
    return DiscHit(select(0.0, rest * rest, hits), depth);
}

// Part `plain` of kernels whose casters are all soft discs of the `filter` transfer.

alias Plain = Disc;
alias PlainHit = DiscHit;

// A visit is so short that the search for the nearest depth is worth a loop of its own.
const SEEKS_APART: bool = true;

fn prepare(view: GpuView, footprint: Footprint) -> Plain {
    return prepare_disc(view, footprint);
}

// The disc, or one that does nothing.
fn only_if(is_there: bool, plain: Plain) -> Plain {
    var disc = plain;
    disc.slope *= select(0.0, 1.0, is_there);
    disc.absorbed *= select(0.0, 1.0, is_there);
    return disc;
}

// `delta`: from the disc's centre [texels].
fn plain_hit(view: GpuView, plain: Plain, delta: vec2<f32>, opaque: f32) -> PlainHit {
    return disc_hit(view, plain, delta, opaque);
}

fn presence(plain: Plain, hit: PlainHit) -> f32 {
    return hit.profile * plain.slope;
}

// The disc of lane `lane` of the subgroup.
fn broadcast(plain: Plain, lane: u32) -> Plain {
    return broadcast_disc(plain, lane);
}

// Whether the disc may touch texel centres in the box lo..hi.
fn plain_touches(view: GpuView, footprint: Footprint, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    return disc_touches(view, footprint.bounds, lo, hi);
}

// Hit of a ray with a puff.

// A puff absorbs along the ray's chord through the sphere in front of the opaque surface: its transfer along
// a diameter, to the power of the chord's share of the diameter.
fn puff_hit(
    view: GpuView,
    bounds: vec4<f32>,
    color: vec3<f32>,
    thin: f32,
    alpha: f32,
    texel: vec2<f32>,
    opaque_depth: f32,
    material_id: u32,
) -> Hit {
    let range = view.far - view.near;
    let center = view.near + bounds.w * range; // along the axis [m]
    let w = vec3((texel - view.size * 0.5) / view.scale, 1.0);
    let middle = (bounds.xy - view.size * 0.5) / view.scale;
    // Squared distance of the ray from the centre [radii²], and metres along the axis per radius.
    var miss2: f32;
    var radius_axis: f32;
    var closest: f32;
    if is_beside(bounds) {
        let apart = cross(bounds.xyw, w);
        miss2 = dot(apart, apart) / dot(w, w) / (bounds.z * bounds.z);
        radius_axis = -bounds.z / length(w);
        closest = dot(bounds.xyw, w) / dot(w, w);
    } else if view.perspective > 0.0 {
        let c = vec3(middle, 1.0);
        let distance = center * length(c);
        let radius = bounds.z * distance;
        let apart = cross(c, w - c);
        miss2 = dot(apart, apart) / dot(w, w) * (center * center) / (radius * radius);
        radius_axis = radius / length(w);
        closest = center * dot(c, w) / dot(w, w);
    } else {
        let delta = (texel - bounds.xy) / bounds.z;
        miss2 = dot(delta, delta);
        radius_axis = bounds.z / view.scale;
        closest = center;
    }
    if miss2 >= 1.0 {
        return MISS;
    }
    let half_chord = sqrt(1.0 - miss2); // [radii]
    let first = max(closest - half_chord * radius_axis, view.near);
    let last = min(closest + half_chord * radius_axis, view.near + opaque_depth * range);
    let share = clamp((last - first) / (2.0 * radius_axis), 0.0, 1.0);
    let per_diameter = max(transmittance(materials[material_id].transfer, thin, alpha, color), vec3(1e-9));
    let opacity = 1.0 - pow(max(1.0 - alpha, 1e-9), share);
    let entered = (first - view.near) / range;
    let left = (last - view.near) / range;
    let light = pow(per_diameter, vec3(share));
    let absorbed = tau_absorbed(
        whole_tau(absorption(materials[material_id].transfer, thin, alpha, color)) * share
    );
    let depth = select(-1.0, entered, share > 0.0);
    return Hit(light, color, opacity, depth, depth, left, material_id, absorbed);
}
