// Light past the shadows of a light. CPU reference: crates/gobo-reference/src/shading/receive.rs.

import package::records::light::{
    GpuLight, VIEWPOINTS_MASK, VIEWPOINTS_SHIFT, light_record, shadow_role, shadow_view,
};
import package::records::view::{GpuView, ROLE_FACE, ROLE_WINDOW};
import package::shade::asides::{
    ASIDE_LEAST, ASIDE_NORMAL, ASIDE_POINT, ASIDE_SUM, ASIDE_VIEWS, bits_of, floats_of,
};
import package::shade::incoming::cube_face;
import package::shade::lifted::{Lifted, lift, lifted_point};
import package::shade::taps::{SPLINE_REACH, beyond_spline};
import choice::aside::{aside, lay_aside};
import choice::source::receive_light;

// Least cosine of a slope: 86 degrees.
const MIN_INCIDENCE: f32 = 0.0625;

// Bits beside the index of a shadow's last view: whether the shadow is complete, and the number of its
// light's viewpoint, from 1 on; 0 for a further shadow.
const WHOLE_BIT: u32 = 0x80000000u;
const VIEWPOINT_SHIFT: u32 = 27u;
const VIEWPOINT_MASK: u32 = 0xfu;
const INDEX_MASK: u32 = 0x7ffffffu;

// Weight of a window at a point: it falls towards the border, and is 0 outside.
fn window_share(light: GpuLight, view: GpuView, point: vec3<f32>) -> f32 {
    let p = (view.view_from_world * vec4(point, 1.0)).xyz;
    let spread = view.scale / select(1.0, max(-p.z, 1e-6), view.perspective > 0.0);
    let position = vec2(p.x, -p.y) * spread + view.size * 0.5;
    let inner = min(position, view.size - position);
    // All texels of the filter are the window's own.
    let border = min(inner.x, inner.y) - SPLINE_REACH - beyond_spline(light);
    if !(border > 0.0 && -p.z >= view.near && -p.z <= view.far) {
        return 0.0;
    }
    return min(border / max(view.fade, 1e-3), 1.0);
}

// Light that passes to a point, per channel: the mean over the viewpoints of the light `number` (Heckbert and
// Herf 1997), or any further shadow's share where that is less. `normal`: on the light's side, zero without a
// surface; `reach`: distance that a caster in the maps may be off the point [m], added to the bias; negative
// for no bias at all. One loop for all kinds of shadows: where skipped branches still cost, it reads fewer
// maps than a branch per kind.
fn shadow(
    source: GpuLight,
    number: u32,
    point: vec3<f32>,
    normal: vec3<f32>,
    toward: vec3<f32>,
    reach: f32,
) -> vec3<f32> {
    let cosine = dot(normal, toward);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    // Without a normal there is no slope.
    let slope = source.slope_bias * dot(normal, normal) * sine / max(cosine, MIN_INCIDENCE);
    lay_aside(ASIDE_POINT, bits_of(point, reach));
    lay_aside(ASIDE_NORMAL, bits_of(normal, lift(source) * sine));
    lay_aside(ASIDE_SUM, bits_of(vec3(0.0), 1.0));
    lay_aside(ASIDE_LEAST, bits_of(vec3(1.0), slope));
    var light = source;
    var index = source.first_view;
    var viewpoint = 1u;
    if source.view_count > 0u {
        loop {
            let kept = floats_of(aside(ASIDE_POINT));
            var view: GpuView;
            var lifted: Lifted;
            var share: f32;
            var last: u32; // last view of this shadow
            loop {
                if shadow_role(index) == ROLE_FACE {
                    // Away from the viewpoint, along the world's axes.
                    let from_world = shadow_view(index).view_from_world;
                    let in_view = from_world * vec4(kept.xyz, 1.0);
                    index += cube_face((vec4(in_view.xyz, 0.0) * from_world).xyz);
                }
                view = shadow_view(index);
                lifted = lifted_point(light, view);
                share = select(1.0, window_share(light, view, lifted.point), view.role == ROLE_WINDOW);
                last = index + view.role_count - 1u - view.role_index;
                if share > 0.0 || index >= last {
                    break;
                }
                index += 1u;
            }
            let is_whole = index == last || view.role == ROLE_FACE;
            let flags = select(0u, WHOLE_BIT, is_whole) | (viewpoint << VIEWPOINT_SHIFT);
            lay_aside(ASIDE_VIEWS, vec4(index, last | flags, bitcast<u32>(share), number));
            let received = receive_light(light, index, view, lifted);
            let views = aside(ASIDE_VIEWS);
            let part = bitcast<f32>(views.z);
            let so_far = floats_of(aside(ASIDE_SUM));
            let least = floats_of(aside(ASIDE_LEAST));
            let sum = so_far.xyz + received * (so_far.w * part);
            let rest = so_far.w * (1.0 - part);
            let is_done = rest <= 0.0 || (views.y & WHOLE_BIT) != 0u;
            viewpoint = (views.y >> VIEWPOINT_SHIFT) & VIEWPOINT_MASK;
            let passed = sum / max(1.0 - rest, 1e-6);
            // Beyond the last view all light passes. A further shadow can only take some of it.
            let own = mix(least.xyz, mix(vec3(1.0), passed, 1.0 - rest), 1.0 / f32(max(viewpoint, 1u)));
            let less = select(mix(least.xyz, min(least.xyz, passed), 1.0 - rest), own, viewpoint > 0u);
            lay_aside(ASIDE_LEAST, bits_of(select(least.xyz, less, is_done), least.w));
            lay_aside(ASIDE_SUM, bits_of(select(sum, vec3(0.0), is_done), select(rest, 1.0, is_done)));
            index = select(views.x, views.y & INDEX_MASK, is_done) + 1u;
            light = light_record(views.w);
            let viewpoints = (light.traits >> VIEWPOINTS_SHIFT) & VIEWPOINTS_MASK;
            let next = select(0u, viewpoint + 1u, viewpoint > 0u && viewpoint <= viewpoints);
            viewpoint = select(viewpoint, next, is_done);
            if index >= light.first_view + light.view_count {
                break;
            }
        }
    }
    return floats_of(aside(ASIDE_LEAST)).xyz;
}
