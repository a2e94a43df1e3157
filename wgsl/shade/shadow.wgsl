// Light that the shadows of a light let through. CPU reference: src/reference/shading/receive.rs.

import choice::aside::{aside, lay_aside};
import choice::source::receive_light;
import package::records::light::{GpuLight, light_record, shadow_role, shadow_view};
import package::records::view::{GpuView, ROLE_FACE, ROLE_WINDOW};
import package::shade::asides::{
    ASIDE_LEAST, ASIDE_NORMAL, ASIDE_POINT, ASIDE_SUM, ASIDE_VIEWS, bits_of, floats_of,
};
import package::shade::incoming::cube_face;
import package::shade::lifted::{Lifted, lift, lifted_point};
import package::shade::taps::{SPLINE_REACH, beyond_spline};

// Least cosine of a slope: 86 degrees.
const MIN_INCIDENCE: f32 = 0.0625;

// With the index of a shadow's last view: whether it is complete, and whether it is that of the light itself.
const WHOLE_BIT: u32 = 0x80000000u;
const LIGHT_BIT: u32 = 0x40000000u;
const INDEX_MASK: u32 = 0x3fffffffu;

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

// Least light that any shadow of the light `number` lets through, per channel. `normal` is on the light's side,
// zero without a surface; `reach`: distance that a caster in the maps may be off the point [m]. Where branches
// cost what they skip, one loop reads fewer maps than a branch for each kind.
fn shadow(source: GpuLight, number: u32, point: vec3<f32>, normal: vec3<f32>, toward: vec3<f32>, reach: f32) -> vec3<f32> {
    let cosine = dot(normal, toward);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    // Without a normal there is no slope.
    let slope = source.slope_bias * dot(normal, normal) * sine / max(cosine, MIN_INCIDENCE);
    lay_aside(ASIDE_POINT, bits_of(point, source.bias + reach));
    lay_aside(ASIDE_NORMAL, bits_of(normal, lift(source) * sine));
    lay_aside(ASIDE_SUM, bits_of(vec3(0.0), 1.0));
    lay_aside(ASIDE_LEAST, bits_of(vec3(1.0), slope));
    var light = source;
    var index = source.first_view;
    var of_light = true; // a further shadow can only take light
    if source.view_count > 0u {
        loop {
            let kept = floats_of(aside(ASIDE_POINT));
            let face = cube_face(kept.xyz - light.position);
            var view: GpuView;
            var lifted: Lifted;
            var share: f32;
            var last: u32; // last view of this shadow
            loop {
                index += select(0u, face, shadow_role(index) == ROLE_FACE);
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
            let flags = select(0u, WHOLE_BIT, is_whole) | select(0u, LIGHT_BIT, of_light);
            lay_aside(ASIDE_VIEWS, vec4(index, last | flags, bitcast<u32>(share), number));
            let received = receive_light(light, index, view, lifted);
            let views = aside(ASIDE_VIEWS);
            let part = bitcast<f32>(views.z);
            let so_far = floats_of(aside(ASIDE_SUM));
            let least = floats_of(aside(ASIDE_LEAST));
            let sum = so_far.xyz + received * (so_far.w * part);
            let rest = so_far.w * (1.0 - part);
            let is_done = rest <= 0.0 || (views.y & WHOLE_BIT) != 0u;
            of_light = (views.y & LIGHT_BIT) != 0u;
            let passed = sum / max(1.0 - rest, 1e-6);
            let less = mix(least.xyz, select(min(least.xyz, passed), passed, of_light), 1.0 - rest);
            lay_aside(ASIDE_LEAST, bits_of(select(least.xyz, less, is_done), least.w));
            lay_aside(ASIDE_SUM, bits_of(select(sum, vec3(0.0), is_done), select(rest, 1.0, is_done)));
            of_light = of_light && !is_done;
            index = select(views.x, views.y & INDEX_MASK, is_done) + 1u;
            light = light_record(views.w);
            if index >= light.first_view + light.view_count {
                break;
            }
        }
    }
    return floats_of(aside(ASIDE_LEAST)).xyz;
}
