// The receiver of a look-up, which `shadow` lays aside, as views need it.

import choice::aside::aside;
import package::features::HAS_FILTERS;
import package::records::area::has_area;
import package::records::light::GpuLight;
import package::records::material::{RECEIVES_CURVE, RECEIVES_NEAREST};
import package::records::view::GpuView;
import package::shade::asides::{ASIDE_LEAST, ASIDE_NORMAL, ASIDE_POINT, floats_of};
import package::shade::receiver::receives;
import package::shade::taps::beyond_spline;
import package::shade::tint::set_plane;

// The receiver's plane in a view.
fn set_own_plane(view: GpuView) {
    set_plane(view, floats_of(aside(ASIDE_POINT)).xyz, floats_of(aside(ASIDE_NORMAL)).xyz);
}

// Edge of a texel of the view at the point's depth [m].
fn texel_size(view: GpuView, point: vec3<f32>) -> f32 {
    let along = -(view.view_from_world * vec4(point, 1.0)).z;
    return select(1.0, max(along, 0.0), view.perspective > 0.0) / view.scale;
}

// How far a point is lifted along its normal, over the depth that a slope spans within the filter [texels, times
// the slope's sine].
fn lift(light: GpuLight) -> f32 {
    return light.normal_bias + 0.5 + beyond_spline(light);
}

// Whether the light has penumbrae on the receiver. Levels hold all casters: receivers that only some casters tint read
// the map.
fn is_soft(light: GpuLight) -> bool {
    return has_area(light) && (receives == RECEIVES_CURVE || receives == RECEIVES_NEAREST);
}

// The point of a look-up lifted off its surface, as a view needs it.
struct Lifted {
    point: vec3<f32>,
    bias: f32, // [m]
}

fn lifted_point(light: GpuLight, view: GpuView) -> Lifted {
    let kept = floats_of(aside(ASIDE_POINT));
    let surface = floats_of(aside(ASIDE_NORMAL));
    let texel = texel_size(view, kept.xyz);
    // The bias is a part of the normal bias: edges of shadows move with the point.
    let sine = surface.w / lift(light);
    let covered = light.bias * sqrt(max(1.0 - sine * sine, 0.0));
    let part = min(light.normal_bias * sine * texel, covered);
    // In spots what shades the point ends at its own plane.
    let rest = select(surface.w * texel - part, 0.0, is_soft(light));
    let point = kept.xyz + surface.xyz * rest;
    if HAS_FILTERS {
        return Lifted(point, kept.w + floats_of(aside(ASIDE_LEAST)).w * texel);
    }
    return Lifted(point, kept.w);
}
