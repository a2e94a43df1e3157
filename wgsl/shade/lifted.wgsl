// The receiver of a look-up, and its point for a view.

import package::features::HAS_FILTERS;
import package::records::area::has_area;
import package::records::light::{GpuLight, TEXELS_BIT};
import package::records::material::{RECEIVES_CURVE, RECEIVES_NEAREST};
import package::records::view::GpuView;
import package::shade::receiver::{receives, set_plane};
import package::shade::taps::{FILTER_BOX, beyond_spline, filter_of};

struct Receiver {
    point: vec3<f32>,  // world space [m]
    normal: vec3<f32>, // on the light's side; zero without a surface
    reach: f32,        // of `shadow` [m]
    sine: f32,         // of the slope
    distance: f32,     // from the light [m]
    slope: f32,        // slope-scaled bias [texels]
}

// The receiver's plane in a view.
fn set_own_plane(view: GpuView, receiver: Receiver) {
    set_plane(view, receiver.point, receiver.normal);
}

// Edge of a texel of the view at the point's depth [m].
fn texel_size(view: GpuView, point: vec3<f32>) -> f32 {
    let along = -(view.view_from_world * vec4(point, 1.0)).z;
    return select(1.0, max(along, 0.0), view.perspective > 0.0) / view.scale;
}

// Least and largest bias in texels, as shares of the view's depth range. The least is two steps of a curve's
// depths.
const LEAST_BIAS: f32 = 0.000030517578125;
const LARGEST_BIAS: f32 = 0.001953125;

// Least cosine of a slope that a bias in texels covers alone: 66 degrees.
const LEAST_COSINE: f32 = 0.4;

// Least bias of a receiver that is a caster, whose neighbours overlap it [texels].
const CASTER_BIAS: f32 = 4.0;

// Depth bias in the view [m]. A bias in texels covers as much of the slope as it can, so that the point moves
// less. `texel`: edge of a texel at the point's depth [m]; `sine`: of the slope; `least`: [texels].
fn depth_bias(light: GpuLight, view: GpuView, texel: f32, sine: f32, least: f32) -> f32 {
    let slope = light.normal_bias * sine / max(sqrt(max(1.0 - sine * sine, 0.0)), LEAST_COSINE);
    let range = view.far - view.near;
    let of_texels = clamp(
        max(max(light.bias, least), slope) * texel,
        LEAST_BIAS * range,
        LARGEST_BIAS * range,
    );
    return select(light.bias, of_texels, (light.traits & TEXELS_BIT) != 0u);
}

// Distance by which a point is lifted along its normal, including the depth that a slope spans within the
// filter [texels, times the slope's sine].
fn lift(light: GpuLight) -> f32 {
    return light.normal_bias + 0.5 + beyond_spline(light);
}

// Lift of a point along its normal where the filter reaches beyond the spline [texels]. `slope`: the
// normal along the view's x and y. A plane's depths change along these, also where it faces a lamp; a box
// reaches as far as its corners.
fn wide_lift(light: GpuLight, slope: vec2<f32>) -> f32 {
    let along = abs(slope.x) + abs(slope.y);
    let reach = select(length(slope), along, filter_of(light).kind == FILTER_BOX);
    return (light.normal_bias + 0.5) * length(slope) + beyond_spline(light) * reach;
}

// Whether the light has penumbrae on the receiver. Levels hold all casters, so receivers that only some
// casters tint read the map.
fn is_soft(light: GpuLight) -> bool {
    return has_area(light) & ((receives == RECEIVES_CURVE) | (receives == RECEIVES_NEAREST));
}

// The point of a look-up, lifted off its surface for a view.
struct Lifted {
    point: vec3<f32>,
    bias: f32, // [m]
    tint_bias: f32, // with respect to translucent casters [m]
}

fn lifted_point(light: GpuLight, view: GpuView, receiver: Receiver) -> Lifted {
    let normal = receiver.normal;
    let texel = texel_size(view, receiver.point);
    // The bias replaces a part of the normal bias, because edges of shadows move with the point.
    let has_normal = any(normal != vec3(0.0));
    let is_wide = beyond_spline(light) > 0.0;
    let slope = (view.view_from_world * vec4(normal, 0.0)).xy;
    let along = lift(light) * receiver.sine;
    let seen_sine = along / lift(light);
    let sine = select(seen_sine, max(seen_sine, length(slope)), is_wide);
    let raised = select(along, max(along, wide_lift(light, slope)), is_wide);
    let least = select(0.0, CASTER_BIAS, receiver.reach > 0.0);
    let bias = depth_bias(light, view, texel, select(0.0, sine, has_normal), least);
    let covered = bias * sqrt(max(1.0 - sine * sine, 0.0));
    let part = min(light.normal_bias * sine * texel, covered);
    // With spots, occluders end at the point's own plane.
    let rest = select(raised * texel - part, 0.0, is_soft(light));
    let point = receiver.point + normal * rest;
    // A point without a normal is on no translucent caster that could tint it.
    let tint_bias = select(depth_bias(light, view, 0.0, 0.0, 0.0), bias, has_normal | (receiver.reach > 0.0));
    var added = max(receiver.reach, 0.0);
    if HAS_FILTERS {
        added += receiver.slope * texel;
    }
    let is_biased = receiver.reach >= 0.0;
    return Lifted(point, select(0.0, bias, is_biased) + added, select(0.0, tint_bias, is_biased) + added);
}
