// Spot: the part of a shadow map that an area light covers, seen from a point through an occluder's depth.

import package::curve::node::DEPTHS;
import package::records::area::{AREA_FLAT, GpuArea};
import package::records::view::GpuView;
import package::shade::lifted::Receiver;
import package::shade::outline::outline_of;
import package::shade::seen_plane::seen_plane;

// Radius of the widest spot that a level filters [blocks]: its box is 4.5 blocks wide, that of half the
// radius 1.6 blocks.
const WIDEST: f32 = 2.8;
// Radius up to which a spot reads the map itself instead of a level [texels].
const SHARP: f32 = WIDEST;
// Square of the least width of the box that filters the map [texels^2]: with a texel's own width, as wide as
// a quadratic B-spline.
const LEAST_SQUARE: f32 = 2.0;
// Aspect ratio of a rectangle up to which its shorter edge chooses the level; beyond, the longer edge divided
// by this.
const LONGEST: f32 = 3.0;
// Half-width of the range of spots in which two levels, or a level and the map, share an occluder, relative
// to the radius at which one takes over from the other.
const FADE: f32 = 0.125;
// Least inverse distance.
const LEAST_INVERSE: f32 = 1e-12;
// Cosine between a plane's normal and a ray below which the plane has no depth along it.
const EDGE_ON_PLANE: f32 = 0.02;

// The view of the look-up, and the point in it. Depths are steps of the fixed point from the near plane,
// distances are the same steps from the eye or, in a parallel view, from its plane.
var<private> spot_view: GpuView;
var<private> spot_center: vec2<f32>;   // [texels]
var<private> spot_near: f32;           // distance of depth 0
var<private> spot_distance: f32;       // of the point
var<private> spot_bias: f32;
var<private> spot_radius: f32;         // [texels], in a parallel view per distance
var<private> spot_shape: vec2<f32>;    // half-widths along the window's axes, relative to the radius
var<private> spot_turned: bool;        // whether these axes are y and x, so that the second is the longer one
var<private> spot_round: bool;         // of a sphere or a sun
var<private> spot_shear: f32;          // of the window along its first axis, per step along its second
// Plane of the receiver. Its distance along the ray through a texel, in a perspective view the inverse, is
// linear in the texel.
var<private> plane_at_zero: f32;
var<private> plane_by_texel: vec2<f32>;

// A vector along x and y, turned to the window's axes; or back.
fn turned(along: vec2<f32>) -> vec2<f32> {
    return select(along, along.yx, spot_turned);
}

// `p`: the point in the view [m]; `per_metre`: depth steps.
fn set_plane_depth(view: GpuView, p: vec3<f32>, normal: vec3<f32>, per_metre: f32) {
    let perspective = view.perspective > 0.0;
    let by_slope = vec2(normal.x, -normal.y) / view.scale;
    let meets = select(normal.z, dot(normal, p), perspective);
    let long = select(1.0, length(p), perspective);
    let has_normal = any(normal != vec3(0.0));
    // An edge-on plane, or no surface, has the depth of the point everywhere.
    let is_none = (abs(meets) < EDGE_ON_PLANE * long) | !has_normal;
    let by_texel = by_slope / select(meets, 1.0, is_none);
    let scale = select(per_metre, 1.0 / per_metre, perspective);
    let at_point = select(spot_distance, 1.0 / spot_distance, perspective);
    var seen = vec2(0.0);
    if !has_normal {
        let slack = spot_bias * select(1.0, at_point * at_point, perspective);
        seen = seen_plane(view, spot_near, spot_center, at_point, slack);
    }
    plane_by_texel = select(by_texel * scale, seen, is_none);
    plane_at_zero = at_point - dot(plane_by_texel, spot_center);
}

fn set_spot(view: GpuView, area: GpuArea, receiver: Receiver, bias: f32) {
    let p = (view.view_from_world * vec4(receiver.point, 1.0)).xyz;
    let perspective = view.perspective > 0.0;
    let metres = select(-p.z, max(-p.z, 1e-6), perspective);
    let per_metre = DEPTHS / (view.far - view.near);
    spot_view = view;
    spot_near = view.near * per_metre;
    spot_distance = metres * per_metre;
    let center = vec2(p.x, -p.y) * (view.scale / select(1.0, metres, perspective)) + view.size * 0.5;
    // Cells are counted in floats.
    spot_center = clamp(center, vec2(-1e6), vec2(1e6));
    spot_bias = bias * per_metre;
    let outline = outline_of(view, area, p, receiver.distance);
    spot_round = area.kind != AREA_FLAT;
    spot_turned = outline.turned;
    spot_shear = outline.shear;
    let half = outline.half;
    let radius = max(min(half.x, half.y), max(half.x, half.y) / LONGEST);
    spot_radius = radius * view.scale / select(per_metre, metres, perspective);
    spot_shape = half / max(radius, 1e-9);
    set_plane_depth(view, p, (view.view_from_world * vec4(receiver.normal, 0.0)).xyz, per_metre);
}

// Radius of the spot at a depth [texels] (Fernando 2005: the penumbra from similar triangles).
fn spot_at(depth: f32) -> f32 {
    let distance = depth + spot_near;
    let divisor = select(1.0, max(distance, 1e-6), spot_view.perspective > 0.0);
    return spot_radius * (spot_distance - distance) / divisor;
}

// Depth at which a spot has a radius of `texels`.
fn depth_of_spot(texels: f32) -> f32 {
    let part = texels / max(spot_radius, 1e-9);
    let by_distance = spot_distance / (1.0 + part);
    return select(spot_distance - part, by_distance, spot_view.perspective > 0.0) - spot_near;
}

// Depths between which the occluders of spots wider than `texels` fade into those of narrower ones.
fn fade_at(texels: f32) -> vec2<f32> {
    return vec2(depth_of_spot(texels * (1.0 + FADE)), depth_of_spot(texels * (1.0 - FADE)));
}

// Variation of the receiver's plane within `around` texels, for `receiver_end`.
fn slack_within(around: f32) -> f32 {
    return (abs(plane_by_texel.x) + abs(plane_by_texel.y)) * around;
}

// Depth of the receiver along the ray through `texel`, less `slack`.
fn receiver_end(texel: vec2<f32>, slack: f32) -> f32 {
    let linear = plane_at_zero + dot(plane_by_texel, texel);
    let by_distance = 1.0 / max(linear + slack, LEAST_INVERSE);
    let distance = select(linear - slack, by_distance, spot_view.perspective > 0.0);
    return min(distance, spot_distance) - spot_near - spot_bias;
}

// Box that filters spots, together with the blocks or texels that it covers.
struct Box {
    per_square: vec2<f32>, // squared widths along its axes [blocks^2], per squared radius of a spot [texels]
    less: f32,             // squared width that blocks add
    least: f32,            // least squared width
}

fn box_widths(box: Box, texels: f32) -> vec2<f32> {
    return sqrt(max(box.per_square * (texels * texels) - box.less, vec2(box.least)));
}

// Distance of the centres of a box and of a block that touch, along its axes.
fn box_reach(widths: vec2<f32>) -> vec2<f32> {
    return 0.5 * (widths + 1.0);
}

// Share of a block at `off` the box's centre that the box covers.
fn box_cover(reach: vec2<f32>, off: vec2<f32>) -> f32 {
    let over = saturate(reach - abs(off));
    return over.x * over.y;
}

fn box_area(widths: vec2<f32>) -> f32 {
    return widths.x * widths.y;
}

// Blocks overlap: their own variance is that of a box of 3.25 squared widths. With them the box that filters
// a spot is closest to a disc at a variance slightly above the disc's. `edge`: of a block [texels].
fn box_of_level(edge: f32) -> Box {
    let shape = spot_shape / edge;
    let less = select(3.25, 2.75, spot_round) - 9.0 / (edge * edge);
    return Box(3.0 * shape * shape, less, 1.0);
}

fn box_of_map() -> Box {
    return Box(3.0 * spot_shape * spot_shape, 1.0, LEAST_SQUARE);
}
