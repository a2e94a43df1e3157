// Transmittance from an area light to a point: through the levels of a map, and through the map itself.

import package::bind::sampled::{filters, nearests};
import package::curve::node::DEPTHS;
import package::curve::pages::curve_light;
import package::features::NODES;
import package::records::light::GpuLight;
import package::records::view::GpuView;
import package::shade::level_light::NEVER;
import package::shade::lifted::{Lifted, Receiver, is_soft};
import package::shade::near_spot::{before_taken, evaluate_map, near_light};
import package::shade::nearest_lit::nearest_lit;
import package::shade::receive::receive;
import package::shade::receiver::TOUCH;
import package::shade::spot::{FADE, WIDEST, receiver_end, spot_at, spot_bias, spot_center, spot_view};
import package::shade::taps::spline;
import package::shade::through_levels::{
    Leveled, MIN, colored_share, fade_into, relied_on, through_levels,
};

fn receive_light(
    light: GpuLight,
    index: u32,
    view: GpuView,
    receiver: Receiver,
    lifted: Lifted,
) -> vec3<f32> {
    if is_soft(light) {
        return through_map(view, through_levels(light, index, view, receiver, lifted));
    }
    return receive(light, view, receiver, lifted);
}

// Light past occluders close to the receiver, from the map itself, and light past occluders that hide others.
fn through_map(view: GpuView, leveled: Leveled) -> vec3<f32> {
    let is_near = leveled.near != NEVER;
    evaluate_map(min(spot_at(leveled.near), WIDEST * (1.0 + FADE)), leveled.since, is_near);
    let before = before_taken();
    let narrow = 1.0 - near_light.taken / max(before, vec3(MIN));
    let behind = max(near_light.before - near_light.widest, vec3(0.0));
    let widest = behind / max(near_light.before, vec3(MIN));
    let share = colored_share(max(narrow, vec3(0.0)), widest, behind);
    let known = select(vec3(1.0), relied_on(before), is_near);
    let unknown = leveled.passed * (1.0 - known);
    let is_hidden = any(unknown > vec3(0.0));
    let is_first = is_hidden & (leveled.hidden_to == 0u);
    let hidden_since = select(fade_into(leveled.hidden_from), leveled.since, is_first);
    // 0 where nothing is hidden: no level is asked.
    let first = select(leveled.hidden_to, 1u, is_hidden);
    let around = nearest_lit(view, leveled.number, first, leveled.last, hidden_since);
    let passed = leveled.passed * known * select(vec3(1.0), share, is_near);
    return (passed + (leveled.hidden + unknown) * around) * touching_light(leveled.touches);
}

// Light past filters alone that meet an opaque receiver's plane within its bias.

// Texels of a round.
const TOUCH_TEXELS: u32 = 9u;
// Least light to divide by.
const MIN_LIGHT: f32 = 1e-4;
// Rounding of depths along a plane that faces the light, in steps of a curve's depths.
const PLANE_ROUNDING: f32 = 0.0625;

// A filter that crosses the plane is behind a part of it. Texels where the plane is nearer than the point and
// the others are averaged apart, and the darker mean counts: all texels of one side see a filter before the
// point, and none of the nearer side see one behind it. Where the plane faces the light no texel is nearer:
// then the darkest of the halves on each side of the point, so that no texel without the filter counts.
fn touching_light(is_asked: bool) -> vec3<f32> {
    let own = receiver_end(spot_center, 0.0);
    let touch = spot_bias * (1.0 + TOUCH);
    let middle = floor(spot_center);
    let weights_x = spline(spot_center.x - middle.x - 0.5);
    let weights_y = spline(spot_center.y - middle.y - 0.5);
    var darkest = vec3(1.0);
    var faces_light = false;
    // Light, and weight.
    var nearer = vec4(0.0);
    var deeper = vec4(0.0);
    var i = 0u;
    // Three rounds: by depth, by column and by row.
    let count = select(0u, 3u * TOUCH_TEXELS, is_asked);
    if count > 0u {
        loop {
            let round = i / TOUCH_TEXELS;
            let step = vec2(i % 3u, i / 3u % 3u);
            let texel = middle + vec2<f32>(step) - 1.0;
            let at = spot_view.origin + vec2<u32>(clamp(texel, vec2(0.0), spot_view.size - 1.0));
            let end = receiver_end(texel + 0.5, 0.0);
            let last = min(end, own) + touch;
            var light = vec3(1.0);
            if NODES > 0u {
                let before = curve_light(spot_view, at, own / DEPTHS);
                let behind = curve_light(spot_view, at, last / DEPTHS);
                light = select(vec3(1.0), behind / max(before, vec3(MIN_LIGHT)), before > vec3(MIN_LIGHT));
            } else {
                let depth = textureLoad(nearests, at, spot_view.layer, 0).r * DEPTHS;
                let is_between = (depth >= own) & (depth < min(last, DEPTHS));
                light = select(light, textureLoad(filters, at, spot_view.layer, 0).rgb, is_between);
            }
            let weighted = vec4(light, 1.0) * (weights_x[step.x] * weights_y[step.y]);
            let is_beyond = texel + 0.5 >= spot_center;
            let is_deep = select(
                select(end + PLANE_ROUNDING >= own, is_beyond.x, round == 1u),
                is_beyond.y,
                round == 2u,
            );
            nearer += select(weighted, vec4(0.0), is_deep);
            deeper += select(vec4(0.0), weighted, is_deep);
            i += 1u;
            if i % TOUCH_TEXELS == 0u {
                let a = select(vec3(1.0), nearer.xyz / max(nearer.w, MIN_LIGHT), nearer.w > MIN_LIGHT);
                let b = select(vec3(1.0), deeper.xyz / max(deeper.w, MIN_LIGHT), deeper.w > MIN_LIGHT);
                faces_light = faces_light | ((round == 0u) & (nearer.w <= MIN_LIGHT));
                let darker = select(a, b, sum_of(b) < sum_of(a));
                let counts = (round == 0u) | (faces_light & (sum_of(darker) < sum_of(darkest)));
                darkest = select(darkest, darker, counts);
                nearer = vec4(0.0);
                deeper = vec4(0.0);
            }
            if i >= count {
                break;
            }
        }
    }
    return darkest;
}

fn sum_of(light: vec3<f32>) -> f32 {
    return light.x + light.y + light.z;
}
