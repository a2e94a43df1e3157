// Extents of casters in a map. CPU reference: crates/gobo-reference/src/project.rs,
// crates/gobo-reference/src/brick.rs, crates/gobo-reference/src/capsule.rs.

import package::hit::capsule::{CapsuleSetup, capsule_touches, radius_at};
import package::project::conic::ENDLESS;
import package::records::brick::{Brick, voxel_edges};
import package::records::view::{GpuView, MIN_DISTANCE, TILE_SIZE};
import choice::writes::{write_key, write_rect};

// The key and the tile rectangle of a footprint.
fn put(index: u32, key: u32, rect: vec2<u32>) {
    write_key(index, vec2(key, index));
    write_rect(index, rect);
}

// Slopes between which a sphere of radius `sphere` at `(x, distance)` is seen; unbounded if the eye is
// inside.
fn tangents(x: f32, distance: f32, sphere: f32) -> vec2<f32> {
    const UNBOUNDED: f32 = 1e6;
    let t2 = x * x + distance * distance - sphere * sphere;
    if t2 <= 0.0 {
        return vec2(-UNBOUNDED, UNBOUNDED);
    }
    let t = sqrt(t2);
    let low = vec2(x * t - distance * sphere, distance * t + x * sphere);
    let high = vec2(x * t + distance * sphere, distance * t - x * sphere);
    return vec2(
        select(-UNBOUNDED, low.x / low.y, low.y > 0.0),
        select(UNBOUNDED, high.x / high.y, high.y > 0.0),
    );
}

// Largest error of a right angle between edges, as a cosine.
const SQUARE: f32 = 1e-4;
// Rounding of the least distance of a right-angled box, as a share of the distances that it is computed from.
// Small, so that neighbours stay in order where the eye is hardly beside the plane of their shared face.
const DISTANCE_ROUNDING: f32 = 4e-6;

struct BrickExtent {
    lo: vec2<f32>,    // box in the map [texels], where `nearest` is in front of the eye
    hi: vec2<f32>,
    nearest: f32,     // along the axis [m]
    farthest: f32,
    least: f32,       // lower bound of the distance of its nearest point from the origin of view space [m]
}

// `center`: of the box, in view space [m].
fn brick_extent(view: GpuView, brick: Brick, center: vec3<f32>) -> BrickExtent {
    let edges = voxel_edges(brick);
    let half_size = (brick.high - brick.low) * 0.5;
    let rotation = mat3x3(
        view.view_from_world[0].xyz,
        view.view_from_world[1].xyz,
        view.view_from_world[2].xyz,
    );
    let x = rotation * edges[0] * half_size.x;
    let y = rotation * edges[1] * half_size.y;
    let z = rotation * edges[2] * half_size.z;
    let reach = abs(x.z) + abs(y.z) + abs(z.z);
    var all = BrickExtent(vec2(1e30), vec2(-1e30), -center.z - reach, -center.z + reach, 0.0);
    for (var i = 0u; i < 8u; i += 1u) {
        let sign = select(vec3(-1.0), vec3(1.0), (vec3(i) & vec3(1u, 2u, 4u)) != vec3(0u));
        let corner = center + x * sign.x + y * sign.y + z * sign.z;
        let per_metre = select(1.0, 1.0 / -corner.z, view.perspective > 0.0);
        let texel = vec2(corner.x, -corner.y) * view.scale * per_metre + view.size * 0.5;
        all.lo = min(all.lo, texel);
        all.hi = max(all.hi, texel);
    }
    let lengths = vec3(length(x), length(y), length(z));
    let skews = abs(vec3(dot(x, y), dot(y, z), dot(z, x))) / (lengths * lengths.yzx);
    let skew = max(max(skews.x, skews.y), skews.z);
    let away = length(center);
    if skew < SQUARE {
        let beside = abs(vec3(dot(center, x), dot(center, y), dot(center, z))) / lengths;
        all.least = length(max(beside - lengths, vec3(0.0)));
    } else {
        all.least = away - length(abs(x) + abs(y) + abs(z));
    }
    let rounding = (min(skew, SQUARE) + DISTANCE_ROUNDING) * (away + lengths.x + lengths.y + lengths.z);
    all.least = max(all.least - rounding, 0.0);
    return all;
}

// Extent of a capsule of a strand in a view.
struct CapsuleExtent {
    bounds: vec4<f32>, // of its footprint: middle of its axis, reach from the axis [texels], light depth
    half: vec2<f32>,  // from the middle to its last end [texels]
    lo: vec2<f32>,    // box in the map [texels]
    hi: vec2<f32>,
    nearest: f32,     // light depths
    farthest: f32,
    least: f32,       // lower bound of its distance from the light; 0 if that may be inside [m]
}

// Factor of a capsule's radius up to which it reaches at an end. `cosine`: of the end's plane with the axis;
// `slope` of the radius. Rust: src/model/strand.rs.
fn mitre(cosine: f32, slope: f32) -> f32 {
    let bounded = clamp(cosine, 0.5, 1.0);
    let tangent = sqrt(1.0 - bounded * bounded) / bounded;
    return 1.0 / (bounded * max(1.0 - slope * tangent, 0.5));
}

// Radius of a circle around the projection of a sphere's centre that contains the projected sphere [texels].
fn circle(view: GpuView, center: vec3<f32>, radius: f32) -> f32 {
    let sine = radius / length(center);
    let slope = length(center.xy) / center.z;
    let tangent = sine / sqrt(1.0 - sine * sine);
    // tan(axis + cone) - tan(axis), outwards from the view's centre.
    let rest = 1.0 - slope * tangent;
    let reach = view.scale * tangent * (1.0 + slope * slope) / rest;
    // Written so that a NaN is endless.
    return select(ENDLESS, reach, sine < 1.0 && rest > 0.0);
}

// The end's sphere, or the first sphere behind it that reaches the near plane: only those reach the map.
fn clipped(view: GpuView, end: vec4<f32>, other: vec4<f32>) -> vec4<f32> {
    let ahead = end.z + end.w;
    let beyond = other.z + other.w;
    let part = min((view.near - ahead) / (beyond - ahead), 1.0);
    return select(end, mix(end, other, part), ahead < view.near && beyond > ahead);
}

fn capsule_extent(view: GpuView, capsule: CapsuleSetup) -> CapsuleExtent {
    let first = capsule.first;
    let last = first + capsule.axis * capsule.length;
    let slope = max(abs(capsule.taper.y), abs(capsule.least.y));
    let at_last = max(radius_at(capsule.taper, capsule.length), radius_at(capsule.least, capsule.length));
    // The ends' spheres, whose hull contains the capsule: centre and radius [m].
    let first_end = vec4(
        first,
        max(capsule.taper.x, capsule.least.x) * mitre(dot(capsule.first_plane, capsule.axis), slope),
    );
    let last_end = vec4(last, at_last * mitre(dot(capsule.last_plane, capsule.axis), slope));
    let reach = max(first_end.w, last_end.w);
    let range = view.far - view.near;
    let center = view.size * 0.5;
    var extent: CapsuleExtent;
    extent.nearest = (min(first.z - first_end.w, last.z - last_end.w) - view.near) / range;
    extent.farthest = (max(first.z + first_end.w, last.z + last_end.w) - view.near) / range;
    let part = clamp(-dot(first, capsule.axis), 0.0, capsule.length);
    extent.least = max(length(first + capsule.axis * part) - reach, 0.0);
    let depth = (0.5 * (first.z + last.z) - view.near) / range;
    if view.perspective == 0.0 {
        let a = first.xy * view.scale + center;
        let b = last.xy * view.scale + center;
        let width = reach * view.scale;
        extent.bounds = vec4((a + b) * 0.5, width, depth);
        extent.half = (b - a) * 0.5;
        extent.lo = min(a, b) - width;
        extent.hi = max(a, b) + width;
        return extent;
    }
    let a = clipped(view, first_end, last_end);
    let b = clipped(view, last_end, first_end);
    let a_x = tangents(a.x, a.z, a.w);
    let a_y = tangents(a.y, a.z, a.w);
    let b_x = tangents(b.x, b.z, b.w);
    let b_y = tangents(b.y, b.z, b.w);
    extent.lo = min(vec2(a_x.x, a_y.x), vec2(b_x.x, b_y.x)) * view.scale + center;
    extent.hi = max(vec2(a_x.y, a_y.y), vec2(b_x.y, b_y.y)) * view.scale + center;
    if extent.least == 0.0 {
        // The light may be inside.
        extent.lo = vec2(-ENDLESS);
        extent.hi = vec2(ENDLESS);
    }
    let width = max(circle(view, a.xyz, a.w), circle(view, b.xyz, b.w));
    let is_beside = min(a.z, b.z) < MIN_DISTANCE || width >= ENDLESS;
    if is_beside {
        extent.bounds = vec4(center, -1.0, depth);
        return extent;
    }
    let at_a = a.xy / a.z * view.scale + center;
    let at_b = b.xy / b.z * view.scale + center;
    extent.bounds = vec4((at_a + at_b) * 0.5, width, depth);
    extent.half = (at_b - at_a) * 0.5;
    return extent;
}

// The tiles of a small rectangle that the capsule touches; (0, 0) for none.
fn capsule_tiles(extent: CapsuleExtent, rect: vec2<u32>) -> vec2<u32> {
    let first = vec2(rect.x & 255u, (rect.x >> 8u) & 255u);
    let last = vec2((rect.x >> 16u) & 255u, rect.x >> 24u);
    if (rect.y & 0xffffu) == 0u || any(last - first >= vec2(4u)) {
        return rect;
    }
    var mask = 0u;
    for (var y = first.y; y <= last.y; y += 1u) {
        for (var x = first.x; x <= last.x; x += 1u) {
            let lo = vec2<f32>(vec2(x, y) * TILE_SIZE) + 0.5;
            if capsule_touches(extent.bounds, extent.half, lo, lo + f32(TILE_SIZE - 1u)) {
                mask |= 1u << ((y - first.y) * 4u + x - first.x);
            }
        }
    }
    return select(vec2(rect.x, (rect.y & 0xffff0000u) | mask), vec2(0u), mask == 0u);
}
