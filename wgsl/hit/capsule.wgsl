// Hit of a ray with a capsule of a strand: a cone between two planes. CPU reference:
// crates/gobo-reference/src/capsule.rs.

import package::bind::uniform::materials;
import package::hit::hit::{Hit, MISS, absorption, to_map};
import package::records::caster::{capsule_of, caster_color};
import package::records::footprint::MIN_RADIUS;
import package::records::record::CasterRecord;
import package::records::tile::SLACK;
import package::records::view::{GpuView, MIN_DISTANCE};
import package::sums::sums::{tau_absorbed, whole_tau};

const PARALLEL: f32 = 1e-8; // least squared sine between a ray and the axis
const LONGEST_WAY: f32 = 1e6;   // [diameters]; seen along the axis, a strand with a longer way covers nothing
const TIP: f32 = 0.9999;    // largest change of the radius along a ray, as a share of the mean radius

// A capsule in a view: to the right, down and along the view's axis [m].
struct CapsuleSetup {
    first: vec3<f32>,
    axis: vec3<f32>, // unit
    length: f32,
    first_plane: vec3<f32>, // normals
    last_plane: vec3<f32>,
    taper: vec2<f32>,   // radius at the first end, and its change along the axis
    least: vec2<f32>, // the same for the least visible radius
    record: CasterRecord, // of its particle
}

// `record`: of the capsule's particle.
fn capsule_setup(view: GpuView, record: CasterRecord) -> CapsuleSetup {
    let capsule = capsule_of(record.id);
    let first = to_view(view, capsule.first);
    let last = to_view(view, capsule.last);
    let length = max(distance(first, last), MIN_DISTANCE);
    let least = vec2(least_radius(view, first.z), least_radius(view, last.z));
    return CapsuleSetup(
        first,
        (last - first) / length,
        length,
        to_map(view, capsule.first_plane),
        to_map(view, capsule.last_plane),
        vec2(capsule.radii.x, (capsule.radii.y - capsule.radii.x) / length),
        vec2(least.x, (least.y - least.x) / length),
        record,
    );
}

fn to_view(view: GpuView, point: vec3<f32>) -> vec3<f32> {
    return (view.view_from_world * vec4(point, 1.0)).xyz * vec3(1.0, -1.0, -1.0);
}

// Least visible radius; negative behind the eye, where no ray is.
fn least_radius(view: GpuView, along: f32) -> f32 {
    return MIN_RADIUS * select(1.0, along, view.perspective > 0.0) / view.scale;
}

// `line`: radius at the first end, and its change along the axis.
fn radius_at(line: vec2<f32>, along: f32) -> f32 {
    return line.x + line.y * along;
}

// Length of a part of a ray in local diameters, the integral of 1 / (2 r): from its middle to its end the
// radius changes linearly by `rise` times `mean`.
fn diameters(length: f32, mean: f32, rise: f32) -> f32 {
    let share = clamp(rise, -TIP, TIP);
    let square = share * share;
    let series = 1.0 + square * (1.0 / 3.0 + square * 0.2);
    let exact = 0.5 * log((1.0 + share) / (1.0 - share)) / select(share, 1.0, share == 0.0);
    return length / (2.0 * mean) * select(exact, series, abs(share) < 0.1);
}

// A ray's way through a capsule.
struct Way {
    inside: f32, // [local diameters]
    whole: f32,  // of the whole cone
    thin: f32,   // ratio of the true radius to the widened one
    depth: f32,  // light depths where it enters and leaves
    end: f32,
}

const NO_WAY: Way = Way(0.0, 1.0, 1.0, -1.0, -1.0);

fn capsule_way(view: GpuView, capsule: CapsuleSetup, texel: vec2<f32>, opaque_depth: f32) -> Way {
    let slope = (texel - view.size * 0.5) / view.scale;
    let is_parallel = view.perspective == 0.0;
    let start = vec3(select(vec2(0.0), slope, is_parallel), 0.0);
    let way = vec3(select(slope, vec2(0.0), is_parallel), 1.0);
    // Relative to the first end; along the ray, from its point closest to that end.
    let square = dot(way, way);
    let to_first = capsule.first - start;
    let closest = dot(to_first, way) / square;
    let off = way * closest - to_first;
    let begin = dot(off, capsule.axis);
    let step = dot(way, capsule.axis);
    let across = cross(capsule.axis, way);
    let is_along = dot(across, across) < PARALLEL * square;
    let sine = max(dot(across, across), PARALLEL * square);
    let miss = dot(off, across);
    // The point where the ray is closest to the axis. A ray parallel to the axis keeps its distance: there,
    // its begin.
    let begins = clamp(begin + (view.near - closest) * step, 0.0, capsule.length) - begin;
    let aside = off - capsule.axis * begin;
    let middle = select(begin, begins, is_along) * step / select(sine, step * step, is_along);
    let miss2 = select(miss * miss / sine, dot(aside, aside), is_along);
    let closest_along = begin + middle * step;
    // One cone for the whole ray, the same for all pieces of a strand.
    let nearest = clamp(closest_along, 0.0, capsule.length);
    let is_thin = radius_at(capsule.taper, nearest) < radius_at(capsule.least, nearest);
    let line = select(capsule.taper, capsule.least, is_thin);
    let radius = radius_at(line, closest_along);
    let grows = line.y * step;
    let open = sine - grows * grows;
    let discriminant = sine * radius * radius - open * miss2;
    // Written so that a NaN is a miss.
    if !(discriminant >= 0.0) {
        return NO_WAY;
    }
    let b = radius * grows;
    let root = sqrt(discriminant);
    let q = b + select(-root, root, b >= 0.0);
    let one = q / open;
    // Both are 0 for a ray from the tip of the cone.
    let other = select((miss2 - radius * radius) / select(q, 1.0, q == 0.0), 0.0, q == 0.0);
    var enters = min(one, other);
    var leaves = max(one, other);
    let endless = LONGEST_WAY * capsule.length;
    if open >= 0.0 && is_along {
        enters = -endless;
        leaves = endless;
    }
    if open < 0.0 {
        // A ray within the cone's own angle stays inside.
        let turn = enters;
        enters = select(-endless, leaves, grows > 0.0);
        leaves = select(turn, endless, grows > 0.0);
    }
    enters += middle;
    leaves += middle;
    let range = view.far - view.near;
    var first = max(enters, view.near - closest);
    var last = min(leaves, view.near + opaque_depth * range - closest);
    let ahead = dot(capsule.first_plane, way);
    let behind = -dot(capsule.last_plane, way);
    let from_first = dot(capsule.first_plane, off);
    let from_last = dot(capsule.last_plane, capsule.axis * capsule.length - off);
    let at_first = -from_first / select(ahead, 1.0, ahead == 0.0);
    let at_last = -from_last / select(behind, 1.0, behind == 0.0);
    first = max(first, max(select(first, at_first, ahead > 0.0), select(first, at_last, behind > 0.0)));
    last = min(last, min(select(last, at_first, ahead < 0.0), select(last, at_last, behind < 0.0)));
    // A ray in a shared plane belongs to the capsule behind the plane.
    let is_outside = ((ahead == 0.0) & (from_first < 0.0)) | ((behind == 0.0) & (from_last <= 0.0));
    let along = begin + 0.5 * (first + last) * step;
    let mean = radius_at(line, along);
    if is_outside || !(first < last && mean > 0.0) {
        return NO_WAY;
    }
    let metres = sqrt(square);
    let inside = diameters(metres * (last - first), mean, 0.5 * grows * (last - first) / mean);
    let mean_of_whole = radius_at(line, begin + 0.5 * (enters + leaves) * step);
    let of_whole = diameters(
        metres * (leaves - enters),
        mean_of_whole,
        0.5 * grows * (leaves - enters) / mean_of_whole,
    );
    return Way(
        inside,
        select(LONGEST_WAY, max(of_whole, inside), open > 0.0 && !is_along),
        // Exactly 1 on every device: division may round otherwise.
        select(1.0, clamp(radius_at(capsule.taper, along) / mean, 0.0, 1.0), is_thin),
        // A ray that begins inside enters at the near plane, never in front of it by rounding.
        max((closest + first - view.near) / range, 0.0),
        max((closest + last - view.near) / range, 0.0),
    );
}

// Absorbed share of light; `tau`: optical depth of a diameter.
fn way_absorbed(way: Way, tau: vec3<f32>) -> vec3<f32> {
    if way.thin >= 1.0 {
        return tau_absorbed(tau * way.inside);
    }
    // The strand covers only part of the texel.
    let covered = way.thin * tau_absorbed(tau * way.whole);
    return tau_absorbed(whole_tau(covered) * (way.inside / way.whole));
}

fn capsule_hit(
    view: GpuView,
    capsule: CapsuleSetup,
    texel: vec2<f32>,
    opaque_depth: f32,
    material_id: u32,
) -> Hit {
    let way = capsule_way(view, capsule, texel, opaque_depth);
    if !(way.inside > 0.0) {
        return MISS;
    }
    let material = materials[material_id];
    let color = min(caster_color(capsule.record, material.transfer) * material.tint, vec4(1.0));
    let tau = whole_tau(absorption(material.transfer, 1.0, color.a, color.rgb));
    let absorbed = way_absorbed(way, tau);
    let opacity = way_absorbed(way, whole_tau(vec3(color.a))).x;
    return Hit(1.0 - absorbed, color.rgb, opacity, way.depth, way.depth, way.end, material_id, absorbed);
}

// From the middle of a capsule to its last end [texels].
fn capsule_half(look: vec4<u32>) -> vec2<f32> {
    return bitcast<vec2<f32>>(look.xy);
}

// Whether some texel centre in the box lo..hi may be in the capsule, by the rectangle around its axis.
// `bounds` and `half`: of its footprint.
fn capsule_touches(bounds: vec4<f32>, half: vec2<f32>, lo: vec2<f32>, hi: vec2<f32>) -> bool {
    let width = bounds.z + SLACK;
    let apart = (lo + hi) * 0.5 - bounds.xy;
    let reach = (hi - lo) * 0.5;
    let size = length(half);
    let along = select(vec2(0.0), half / size, size > 0.0);
    let across = abs(along.x * apart.y - along.y * apart.x);
    let off = abs(dot(along, apart));
    let wide = width + dot(abs(along.yx), reach);
    let long = size + width + dot(abs(along), reach);
    return bounds.z < 0.0 || (across <= wide && off <= long);
}
