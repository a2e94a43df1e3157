// Light past the shadows of a light. CPU reference: crates/gobo-reference/src/shading/receive.rs.

import package::records::light::{
    GpuLight, VIEWPOINTS_MASK, VIEWPOINTS_SHIFT, shadow_role, shadow_view,
};
import package::records::view::{GpuView, ROLE_FACE, ROLE_WINDOW};
import package::shade::incoming::cube_face;
import package::shade::lifted::{Lifted, Receiver, lifted_point};
import package::shade::taps::{SPLINE_REACH, beyond_spline};
import choice::source::receive_light;

// Least cosine of a slope: 86 degrees.
const MIN_INCIDENCE: f32 = 0.0625;

// Weight of a window at a point: it falls towards the border, and is 0 outside.
fn window_share(light: GpuLight, view: GpuView, point: vec3<f32>) -> f32 {
    let p = (view.view_from_world * vec4(point, 1.0)).xyz;
    let spread = view.scale / select(1.0, max(-p.z, 1e-6), view.perspective > 0.0);
    let position = vec2(p.x, -p.y) * spread + view.size * 0.5;
    let inner = min(position, view.size - position);
    // All texels of the filter are the window's own.
    let border = min(inner.x, inner.y) - SPLINE_REACH - beyond_spline(light);
    if !((border > 0.0) & (-p.z >= view.near) & (-p.z <= view.far)) {
        return 0.0;
    }
    return min(border / max(view.fade, 1e-3), 1.0);
}

// Receiver of the light from `toward`. `normal`: on the light's side, zero without a surface; `reach`:
// distance that a caster in the maps may be off the point [m], added to the bias; negative for no bias.
fn receiver_of(
    light: GpuLight,
    point: vec3<f32>,
    normal: vec3<f32>,
    toward: vec3<f32>,
    reach: f32,
) -> Receiver {
    let cosine = dot(normal, toward);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    // Without a normal there is no slope.
    let slope = light.slope_bias * dot(normal, normal) * sine / max(cosine, MIN_INCIDENCE);
    return Receiver(point, normal, reach, sine, length(point - light.position), slope);
}

// Light that passes the views of a light's shadows that were read so far.
struct Passed {
    light: vec3<f32>, // the mean of its viewpoints, or less where a further shadow passes less
    sum: vec3<f32>,   // of the windows of the shadow that is being read
    rest: f32,        // weight of its windows that are left
    viewpoint: u32,   // its number among the light's, from 1 on; 0 for a further shadow
    next: u32,        // view to read next, counted from the light's first
    is_all: bool,     // no view is left
}

const UNSHADED: Passed = Passed(vec3(1.0), vec3(0.0), 1.0, 1u, 0u, false);

// Light past one more view, of which some is left. Per channel, a light has the mean over its viewpoints
// (Heckbert and Herf 1997), or any further shadow's share where that is less. One way for all kinds of
// shadows: where skipped branches still cost, it reads fewer maps than a branch per kind.
fn past_view(so_far: Passed, light: GpuLight, receiver: Receiver) -> Passed {
    var index = light.first_view + so_far.next;
    var view: GpuView;
    var lifted: Lifted;
    var share: f32;
    var last: u32; // last view of this shadow
    loop {
        if shadow_role(index) == ROLE_FACE {
            // Away from the viewpoint, along the world's axes.
            let from_world = shadow_view(index).view_from_world;
            let in_view = from_world * vec4(receiver.point, 1.0);
            index += cube_face((vec4(in_view.xyz, 0.0) * from_world).xyz);
        }
        view = shadow_view(index);
        lifted = lifted_point(light, view, receiver);
        share = select(1.0, window_share(light, view, lifted.point), view.role == ROLE_WINDOW);
        last = index + view.role_count - 1u - view.role_index;
        if (share > 0.0) | (index >= last) {
            break;
        }
        index += 1u;
    }
    let part = so_far.rest * share;
    let rest = so_far.rest * (1.0 - share);
    let is_whole = (index == last) | (view.role == ROLE_FACE) | (rest <= 0.0);
    let next = select(index, last, is_whole) + 1u - light.first_view;
    let viewpoints = (light.traits >> VIEWPOINTS_SHIFT) & VIEWPOINTS_MASK;
    let viewpoint = so_far.viewpoint;
    let following = select(0u, viewpoint + 1u, (viewpoint > 0u) & (viewpoint <= viewpoints));
    let is_all = next >= light.view_count;
    let sum = so_far.sum + receive_light(light, index, view, receiver, lifted) * part;
    if !is_whole {
        return Passed(so_far.light, sum, rest, viewpoint, next, is_all);
    }
    let passed = sum / max(1.0 - rest, 1e-6);
    // Beyond the last view all light passes. A further shadow can only take some of it.
    let mean = mix(so_far.light, mix(vec3(1.0), passed, 1.0 - rest), 1.0 / f32(max(viewpoint, 1u)));
    let less = mix(so_far.light, min(so_far.light, passed), 1.0 - rest);
    return Passed(select(less, mean, viewpoint > 0u), vec3(0.0), 1.0, following, next, is_all);
}

// Light that passes to a point past all views.
fn shadow(light: GpuLight, receiver: Receiver) -> vec3<f32> {
    var passed = UNSHADED;
    if light.view_count > 0u {
        loop {
            passed = past_view(passed, light, receiver);
            if passed.is_all {
                break;
            }
        }
    }
    return passed.light;
}
