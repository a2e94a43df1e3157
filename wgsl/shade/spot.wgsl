// Spot: the part of a shadow map that an area light covers, seen from a point through an occluder's depth.

import package::curve::node::DEPTHS;
import package::records::area::GpuArea;
import package::records::light::GpuLight;
import package::records::view::GpuView;
import package::shade::outline::outline_of;
import package::shade::seen_plane::seen_plane;

// Radius of the widest spot that a level filters [blocks]: its window is 4.5 blocks wide, that of half the
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
// Cosine between a plane's normal and a ray below which the plane has no depth along it.
const EDGE_ON_PLANE: f32 = 0.02;

// The view of the look-up. Depths are in fixed point.
var<private> spot_view: GpuView;
var<private> spot_center: vec2<f32>;   // [texels]
var<private> spot_distance: f32;       // [m]
var<private> spot_bias: f32;
// Hoisted by hand: llvmpipe's compiler leaves divisions in loops.
var<private> spot_inverse: f32;        // 1 / `spot_distance` [1/m]
var<private> spot_step: f32;           // [m]
var<private> spot_per_metre: f32;
var<private> spot_radius: f32;         // [texels], times a distance [m] in a perspective view
var<private> spot_shape: vec2<f32>;    // half-widths along the window's axes, relative to the radius
var<private> spot_turned: bool;        // whether these axes are y and x, so that the second is the longer one
var<private> spot_shear: f32;          // of the window along its first axis, per step along its second
// Plane of the receiver. Its depth along the ray through a texel, `1 / d` in a perspective view and `d` in a
// parallel one, is linear in the texel.
var<private> plane_middle: f32;
var<private> plane_by_texel: vec2<f32>;

fn fixed_of(distance: f32) -> f32 {
    return (distance - spot_view.near) * spot_per_metre;
}

// A vector along x and y, turned to the window's axes; or back.
fn turned(along: vec2<f32>) -> vec2<f32> {
    return select(along, along.yx, spot_turned);
}

fn set_plane_depth(view: GpuView, p: vec3<f32>, normal: vec3<f32>, bias: f32) {
    let perspective = view.perspective > 0.0;
    let by_slope = vec2(normal.x, -normal.y) / view.scale;
    let meets = select(normal.z, dot(normal, p), perspective);
    let long = select(1.0, length(p), perspective);
    let has_normal = any(normal != vec3(0.0));
    // An edge-on plane, or no surface, has the depth of the point everywhere.
    let is_none = abs(meets) < EDGE_ON_PLANE * long || !has_normal;
    let divisor = select(meets, 1.0, is_none);
    let at_point = select(-p.z, spot_inverse, perspective);
    let slack = bias * select(1.0, spot_inverse * spot_inverse, perspective);
    let seen = seen_plane(view, spot_center, at_point, slack, !has_normal);
    let at_middle = at_point - dot(seen, spot_center - view.size * 0.5);
    plane_middle = select(select(-dot(normal, p), -normal.z, perspective) / divisor, at_middle, is_none);
    plane_by_texel = select(by_slope / divisor, seen, is_none);
}

// `normal`: of the surface, on the light's side; zero where there is no surface.
fn set_spot(view: GpuView, light: GpuLight, area: GpuArea, point: vec3<f32>, normal: vec3<f32>, bias: f32) {
    let p = (view.view_from_world * vec4(point, 1.0)).xyz;
    let perspective = view.perspective > 0.0;
    spot_view = view;
    spot_distance = select(-p.z, max(-p.z, 1e-6), perspective);
    spot_inverse = 1.0 / spot_distance;
    spot_step = (view.far - view.near) / DEPTHS;
    spot_per_metre = DEPTHS / (view.far - view.near);
    let spread = view.scale / select(1.0, spot_distance, perspective);
    spot_center = vec2(p.x, -p.y) * spread + view.size * 0.5;
    spot_bias = bias * spot_per_metre;
    let outline = outline_of(view, light, area, p, point);
    spot_turned = outline.turned;
    spot_shear = outline.shear;
    let half = outline.half;
    let radius = max(min(half.x, half.y), max(half.x, half.y) / LONGEST);
    spot_radius = radius * view.scale;
    spot_shape = half / max(radius, 1e-9);
    set_plane_depth(view, p, (view.view_from_world * vec4(normal, 0.0)).xyz, bias);
}

// Radius of the spot at a depth [texels] (Fernando 2005: the penumbra from similar triangles).
fn spot_at(depth: f32) -> f32 {
    let distance = depth * spot_step + spot_view.near;
    let by_distance = 1.0 / max(distance, 1e-6) - spot_inverse;
    return spot_radius * select(spot_distance - distance, by_distance, spot_view.perspective > 0.0);
}

// Depth at which a spot has a radius of `texels`.
fn depth_of_spot(texels: f32) -> f32 {
    let part = texels / max(spot_radius, 1e-9);
    let distance = 1.0 / (spot_inverse + part);
    return fixed_of(select(spot_distance - part, distance, spot_view.perspective > 0.0));
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
    let linear = plane_middle + dot(plane_by_texel, texel - spot_view.size * 0.5);
    let by_distance = 1.0 / max(linear + slack, 1e-7);
    let distance = select(linear - slack, by_distance, spot_view.perspective > 0.0);
    return min(fixed_of(distance), fixed_of(spot_distance)) - spot_bias;
}

// A window on blocks.
struct Window {
    width: vec2<f32>, // along its axes [blocks]
    per_area: f32,
}

// Windows on blocks of one edge: the widest, and two narrower ones.
struct Windows {
    wide: Window,
    middle: Window,
    narrow: Window,
    squares: vec2<f32>, // squared radii of the spots that the first two filter [texels^2]
    per_square: vec2<f32>, // inverse steps from each of these to the next
}

// `widest` and `least`: radii of spots [texels].
fn windows_of(widest: f32, least: f32, per_edge: f32) -> Windows {
    let shape = spot_shape * per_edge;
    let by_square = 3.0 * shape * shape;
    let less = 3.25 - 9.0 * per_edge * per_edge;
    // For narrower spots, the windows are one block wide.
    let low = (1.0 + less) / max(max(by_square.x, by_square.y), 1e-12);
    let wide = widest * widest;
    let narrow = min(max(least * least, low), wide);
    let middle = sqrt(wide * narrow);
    return Windows(
        window_of(by_square * wide - less),
        window_of(by_square * middle - less),
        window_of(by_square * narrow - less),
        vec2(wide, middle),
        1.0 / max(vec2(wide - middle, middle - narrow), vec2(1e-6)),
    );
}

// With the overlap of the blocks and a block's own width, the window that filters a spot is closest to a disc
// at a variance slightly above the disc's. `squares`: of the window's widths.
fn window_of(squares: vec2<f32>) -> Window {
    let width = sqrt(max(squares, vec2(1.0)));
    return Window(width, 1.0 / (width.x * width.y));
}

// Share of a window, at least one block wide, that covers the block at `off` its centre, along its axes.
fn window_cover(off: vec2<f32>, window: Window) -> f32 {
    let over = saturate(0.5 * (window.width + 1.0) - abs(off));
    return over.x * over.y * window.per_area;
}

// Weights of the narrower windows for a spot. A spot between two windows is filtered by both, so that their
// variance is its own, which saves a root and a division per ramp. For each step between windows: its share
// by which the spot is below the wider window.
fn narrower(windows: Windows, texels: f32) -> vec2<f32> {
    return saturate((windows.squares - texels * texels) * windows.per_square);
}
