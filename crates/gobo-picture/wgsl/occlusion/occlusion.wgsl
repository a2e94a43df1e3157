// occlusion: ambient light that nearby surfaces hide. CPU reference: crates/gobo-reference/src/occlusion.rs.
// Rust: crates/gobo-picture/src/stage/occlusion.rs.

import package::bind::picture_in::ambients;
import package::bind::picture_out::occlusions;
import package::bind::uniform::{picture_params, views};
import package::records::pack::{from_octahedral, octahedral};

// A pixel's opaque surface and the ambient light that it sends to the eye: texels of `ambients`.
struct Surroundings {
    depth: f32,         // light depth; 1 without a surface
    normal: vec3<f32>,  // unit, world space; zero for a surface that faces the eye
    light: vec3<f32>,   // ambient light that reaches the eye
}

fn pack_surroundings(surroundings: Surroundings) -> vec4<u32> {
    let faces = select(0.0, 1.0, all(surroundings.normal == vec3(0.0)));
    // At most the largest half.
    let light = min(surroundings.light, vec3(65504.0));
    return vec4(
        bitcast<u32>(surroundings.depth),
        octahedral(surroundings.normal),
        pack2x16float(light.rg),
        pack2x16float(vec2(light.b, faces)),
    );
}

fn unpack_surroundings(bits: vec4<u32>) -> Surroundings {
    let last = unpack2x16float(bits.w);
    let normal = select(from_octahedral(bits.y), vec3(0.0), last.y > 0.0);
    return Surroundings(bitcast<f32>(bits.x), normal, vec3(unpack2x16float(bits.z), last.x));
}

// Transform from pixels and light depths to view space.
struct Screen {
    first: vec2<f32>, // slopes of the middle of the first pixel, upwards
    step: vec2<f32>,  // from pixel to pixel
    near: f32,        // [m]
    range: f32,       // from the near to the far plane [m]
}

fn screen() -> Screen {
    let view = views[0];
    let step = vec2(1.0, -1.0) / view.scale;
    return Screen((0.5 - view.size * 0.5) * step, step, view.near, view.far - view.near);
}

// View-space position at light depth `depth` in the middle of a pixel [m].
fn seen_point(on: Screen, pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    return vec3(on.first + pixel * on.step, -1.0) * (on.near + depth * on.range);
}

// View-space unit normal of a surface at `point`; zero stands for a surface that faces the eye.
fn seen_normal(normal: vec3<f32>, point: vec3<f32>) -> vec3<f32> {
    let turned = normal * mat3x3<f32>(
        picture_params.world_from_view[0].xyz,
        picture_params.world_from_view[1].xyz,
        picture_params.world_from_view[2].xyz,
    );
    return select(turned, -normalize(point), all(normal == vec3(0.0)));
}

fn radius_at(point: vec3<f32>) -> f32 {
    return picture_params.occlusion_radius - picture_params.occlusion_radius_per_distance * point.z;
}

const PI: f32 = 3.1415927;
// Directions of a pixel; the next three pixels have others between them.
const OCCLUDER_DIRECTIONS: u32 = 3u;
// Places along a direction, to either side; 4x4 pixels have others between them, so that no two see the same
// rings.
const OCCLUDER_STEPS: u32 = 6u;
// Offsets of the places of four pixels within their step [quarters].
const PLACES: u32 = 0x2431u;
// Distance of the farthest place [heights of the picture].
const OCCLUDER_REACH: f32 = 0.25;
// Least length of the normal's projection into a slice.
const SLICE_FACING: f32 = 1e-3;
// Distance of the sky, which is on no surface's plane [m].
const SKY_DISTANCE: f32 = 1e20;
// Squared slope up to which surfaces around are flat: depths are rounded.
const FLAT_SQUARE: f32 = 4e-6;
// Instead of 0 in a divisor.
const TINY: f32 = 1e-20;

// The plane of a search: the eye's ray and a direction on the screen.
struct Slice {
    above: vec3<f32>,  // normal of the surface, over the length of its projection into the plane
    along: vec3<f32>,  // in the plane, across that projection, unit
    facing: f32,       // that length
    tilt: f32,         // angle from the direction to the eye to the normal
}

// Integral of the cosine from the direction to the eye up to a horizon [radians].
fn arc(tilt: f32, horizon: f32) -> f32 {
    return 0.25 * (cos(tilt) - cos(2.0 * horizon - tilt) + 2.0 * horizon * sin(tilt));
}

fn slice_of(direction: vec2<f32>, normal: vec3<f32>, to_eye: vec3<f32>) -> Slice {
    let flat = vec3(direction.x, -direction.y, 0.0);
    let across = normalize(cross(flat, to_eye));
    let inside = normal - across * dot(normal, across);
    let facing = max(length(inside), SLICE_FACING);
    let up = inside / facing;
    let along = cross(up, across);
    let tilt = atan2(-dot(along, to_eye), dot(up, to_eye));
    return Slice(normal / facing, along, facing, tilt);
}

struct Around {
    last: vec2<f32>, // pixel of the picture
    reach: f32,      // [pixels]
    per_square: f32, // 1 / radius^2 [1/m^2]
    part: f32,       // of a step: offset of its place
}

// Angle above the surface's plane below which no light comes, on one side of a slice. Beyond its border the
// picture is taken to be as far as at the border, so that rising surfaces go on.
fn risen(
    on: Screen,
    pixel: vec2<f32>,
    point: vec3<f32>,
    slice: Slice,
    step: vec2<f32>,
    around: Around,
) -> f32 {
    var least = 1.0; // cosine of the highest angle
    for (var i = 0u; i < OCCLUDER_STEPS; i += 1u) {
        let part = (f32(i) + around.part) / f32(OCCLUDER_STEPS);
        let sample = pixel + round(step * max(part * part * around.reach, f32(i) + 1.0));
        let inside = clamp(sample, vec2(0.0), around.last);
        let depth = bitcast<f32>(textureLoad(ambients, vec2<i32>(inside), 0).x);
        let away = seen_point(on, sample, depth) - point;
        let above = dot(away, slice.above);
        let along = dot(away, slice.along);
        let cosine = along * inverseSqrt(max(along * along + above * above, TINY));
        // An occluder counts in full up to half the radius, and not at all at the radius.
        let share = saturate((1.0 - dot(away, away) * around.per_square) * (4.0 / 3.0));
        let seen = seen_point(on, inside, depth) - point;
        let rises = dot(seen, slice.above) * slice.facing;
        let is_flat = rises * abs(rises) <= FLAT_SQUARE * dot(seen, seen);
        let counts = depth < 1.0 && !is_flat;
        least = min(least, select(1.0, mix(1.0, cosine, share), counts));
    }
    return acos(clamp(least, -1.0, 1.0));
}

// occlusion, search: the share of the ambient light that reaches a surface past the visible surfaces around
// it, at half the picture's size: a search for horizons (Jimenez et al. 2016, "Practical Real-Time Strategies
// for Accurate Indirect Occlusion", section 4). Unlike the paper: horizons are angles above the surface's own
// plane, so that planes do not occlude themselves, and the sum is divided by the sum without occluders. One
// invocation per 2x2 pixels.
@compute @workgroup_size(8, 8)
fn occlusion_search(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= textureDimensions(occlusions)) {
        return;
    }
    let view = views[0];
    let on = screen();
    let pixel = vec2<f32>(id.xy * 2u);
    let around_pixel = unpack_surroundings(textureLoad(ambients, id.xy * 2u, 0));
    let point = seen_point(on, pixel, around_pixel.depth);
    let normal = seen_normal(around_pixel.normal, point);
    let to_eye = -normalize(point);
    let radius = radius_at(point);
    let reach = min(radius * view.scale / -point.z, OCCLUDER_REACH * view.size.y);
    // Two orthogonal Latin squares: each row and column of four has all directions and all places, and 4x4
    // pixels have every pair.
    let turn = f32((id.x + id.y) & 3u) * 0.25;
    let twice = (id.y << 1u) ^ (((id.y >> 1u) & 1u) * 7u);
    let part = f32((PLACES >> (4u * ((id.x ^ twice) & 3u))) & 7u) * 0.25;
    let around = Around(view.size - 1.0, reach, 1.0 / (radius * radius), part);
    var seen = 0.0;
    var whole = 0.0;
    for (var i = 0u; i < OCCLUDER_DIRECTIONS && around_pixel.depth < 1.0; i += 1u) {
        let angle = (f32(i) + turn) * (PI / f32(OCCLUDER_DIRECTIONS));
        let step = vec2(cos(angle), sin(angle));
        let slice = slice_of(step, normal, to_eye);
        let right = max(slice.tilt + 0.5 * PI - risen(on, pixel, point, slice, step, around), 0.0);
        let back = Slice(slice.above, -slice.along, slice.facing, slice.tilt);
        let left = min(slice.tilt - 0.5 * PI + risen(on, pixel, point, back, -step, around), 0.0);
        seen += slice.facing * max(arc(slice.tilt, left) + arc(slice.tilt, right), 0.0);
        whole += slice.facing * (cos(slice.tilt) + slice.tilt * sin(slice.tilt));
    }
    let share = select(1.0, seen / whole, whole > 0.0);
    textureStore(occlusions, id.xy, vec4(
        bitcast<u32>(share),
        bitcast<u32>(select(SKY_DISTANCE, -point.z, around_pixel.depth < 1.0)),
        0u,
        0u,
    ));
}
