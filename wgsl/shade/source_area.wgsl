// Transmittance from an area light to a point: through the levels of a map, and through the map itself.

import choice::aside::{aside, forget_asides, lay_aside};
import package::records::light::{GpuLight, shadow_view};
import package::records::view::GpuView;
import package::shade::asides::{ASIDE_HIDDEN, ASIDE_PASSED, ASIDE_VIEWS, bits_of, floats_of};
import package::shade::level_light::NEVER;
import package::shade::lifted::{Lifted, is_soft};
import package::shade::near_spot::{before_taken, evaluate_map, near_light};
import package::shade::nearest_lit::nearest_lit;
import package::shade::receive::receive;
import package::shade::spot::{FADE, WIDEST, spot_at, spot_view};
import package::shade::through_levels::{
    Leveled, MIN, TOUCH_BIT, colored_share, relied_on, through_levels,
};
import package::shade::touching::touching_light;

fn receive_light(light: GpuLight, index: u32, view: GpuView, lifted: Lifted) -> vec3<f32> {
    if is_soft(light) {
        return through_map(through_levels(light, index, view, lifted));
    }
    return receive(light, view, lifted);
}

// Light past occluders close to the receiver, from the map itself, and light past occluders that hide others.
fn through_map(leveled: Leveled) -> vec3<f32> {
    forget_asides(leveled.last);
    // Only the values of the view that levels need were kept.
    spot_view = shadow_view(aside(ASIDE_VIEWS).x);
    let is_near = leveled.near != NEVER;
    evaluate_map(min(spot_at(leveled.near), WIDEST * (1.0 + FADE)), leveled.since, is_near);
    // The light behind the levels is laid aside.
    forget_asides(leveled.last);
    let lit = floats_of(aside(ASIDE_PASSED));
    let shaded = aside(ASIDE_HIDDEN);
    let passed = lit.xyz;
    let hidden = floats_of(shaded).xyz;
    let before = before_taken();
    let narrow = 1.0 - near_light.taken / max(before, vec3(MIN));
    let behind = max(near_light.before - near_light.widest, vec3(0.0));
    let widest = behind / max(near_light.before, vec3(MIN));
    let share = colored_share(max(narrow, vec3(0.0)), widest, behind);
    let known = select(vec3(1.0), relied_on(before), is_near);
    let at_map = select(vec3(1.0), share, is_near);
    let unknown = passed * (1.0 - known);
    let is_hidden = any(unknown > vec3(0.0));
    let is_first = is_hidden && all(hidden == vec3(0.0));
    let hidden_since = select(vec2(lit.w, leveled.hidden_end), leveled.since, is_first);
    // 0 where nothing is hidden: no level is asked.
    let first = select(shaded.w & ~TOUCH_BIT, 1u, is_hidden);
    lay_aside(ASIDE_PASSED, bits_of(passed * known * at_map, 0.0));
    lay_aside(ASIDE_HIDDEN, vec4(bits_of(hidden + unknown, 0.0).xyz, shaded.w & TOUCH_BIT));
    let view = shadow_view(aside(ASIDE_VIEWS).x);
    let around = nearest_lit(view, leveled.number, first, leveled.last, hidden_since);
    forget_asides(first);
    let sum = floats_of(aside(ASIDE_PASSED)).xyz + floats_of(aside(ASIDE_HIDDEN)).xyz * around;
    lay_aside(ASIDE_PASSED, bits_of(sum, 0.0));
    let touching = touching_light(aside(ASIDE_HIDDEN).w != 0u);
    forget_asides(first);
    return floats_of(aside(ASIDE_PASSED)).xyz * touching;
}
