// Transmittance from an area light to a point, from the widest spots to the sharpest, from the light on.
// CPU twin: src/reference/shading/soft.rs.

import package::curve::node::DEPTHS;
import package::features::HAS_GAIN;
import package::records::area::{area_of, has_area, level_map, leveled_view};
import package::records::light::GpuLight;
import package::records::material::{RECEIVES_CURVE, RECEIVES_NEAREST};
import package::records::view::GpuView;
import package::shade::fade::light_before;
import package::shade::level_light::{NEVER, evaluate_level, level_light, next_occluder};
import package::shade::receive::{receive, receive_texel};
import package::shade::receiver::{is_solid, receives};
import package::shade::spot::{FADE, SHARP, WIDEST, fade_at, set_spot, spot_at};
import package::shade::taps::{map_taps, tap_weight};

// Weight of a level's result per light before the level, up to a weight of 1.
const EVIDENCE: f32 = 300.0;
// Least light to divide by.
const LEAST: f32 = 1e-4;

fn relied_on(before: vec3<f32>) -> vec3<f32> {
    return clamp(before * EVIDENCE, vec3(0.0), vec3(1.0));
}

// The smallest level whose blocks are large enough for a spot; 0 for the map.
fn level_of(texels: f32, last: u32) -> u32 {
    let near = u32(clamp(ceil(log2(texels / WIDEST)), 1.0, 12.0));
    // Corrects the rounding of the logarithm.
    let up = select(near, near + 1u, texels > WIDEST * f32(1u << near));
    let enough = select(up, up - 1u, up > 1u && texels <= WIDEST * f32(1u << (up - 1u)));
    return select(min(enough, last), 0u, texels <= SHARP);
}

fn receive_area(light: GpuLight, index: u32, view: GpuView, at: vec3<f32>, point: vec3<f32>, normal: vec3<f32>, bias: f32) -> vec3<f32> {
    let taps = map_taps(view, at);
    let range = view.far - view.near;
    if !taps.reaches {
        return vec3(1.0);
    }
    if taps.z > 1.0 + bias / range {
        return vec3(0.0);
    }
    let area = area_of(light);
    let leveled = area.first_leveled + index - light.first_view;
    let last = leveled_view(leveled).y;
    set_spot(view, light, area, point, normal, bias);
    // Loop counts are not constant, so that compilers do not unroll.
    let four = select(0u, 4u, last > 0u);
    var passed = vec3(1.0);
    var sum = vec3(0.0);
    var around = vec3(1.0); // light that reaches the receiver where a level has no light before it
    var since = vec2(-1.0); // fade of the level before
    var number = last;
    var rest_next = NEVER; // next occluder in the window of the level before
    while number > 0u {
        let above = min(number + 2u, last);
        // Every occluder that a level left over is followed, or it would let light through.
        let blocks = select(four, 0u, rest_next != NEVER);
        let next = min(rest_next, next_occluder(level_map(view, leveled, above), blocks, since.x, 0.0, 0.0));
        if next == NEVER {
            break;
        }
        let texels = spot_at(next);
        let found = min(level_of(texels, last), number);
        number = found;
        if found == 0u || (rest_next == NEVER && found + 2u < above) {
            continue;
        }
        let map = level_map(view, leveled, number);
        let to = fade_at(select(WIDEST * map.edge * 0.5, SHARP, number == 1u));
        evaluate_level(map, min(texels, WIDEST * (1.0 + FADE) * map.edge), since, to);
        let known = relied_on(level_light.before);
        let left = min(level_light.before - level_light.taken, level_light.most);
        let share = max(left / max(level_light.before, vec3(LEAST)), vec3(0.0));
        sum += passed * (1.0 - known) * around;
        passed *= known * share;
        // Also no light behind is known, if there was enough of it before.
        let rest = level_light.end / max(level_light.behind, vec3(LEAST));
        around = mix(around, rest, max(known, relied_on(10.0 * level_light.behind)));
        rest_next = level_light.next;
        since = to;
        number -= 1u;
    }
    // Occluders close to the receiver, from the map itself. If levels were skipped, the rest of an occluder in
    // the last one's fade has a spot far wider than the map's texels: it counts as before.
    since = select(since, max(since, vec2(fade_at(SHARP).x)), since.x > 0.0);
    let blocks = select(four, 0u, rest_next != NEVER);
    // The map's look-up decides which filters within the bias tint an opaque receiver.
    let beyond = select(0.0, 2.0 * bias / range * DEPTHS, is_solid);
    let near_next = next_occluder(level_map(view, leveled, 1u), blocks, since.x, 0.5, beyond);
    let is_near = min(rest_next, near_next) != NEVER;
    let count = select(0u, 9u, is_near);
    var behind = vec3(0.0);
    for (var i = 0u; i < count; i += 1u) {
        let texel = taps.middle + vec2(f32(i % 3u), f32(i / 3u)) - 1.0;
        let weight = tap_weight(taps, i);
        behind += receive_texel(view, texel, taps.z, bias / range) * weight;
    }
    // If no level was evaluated, all light is before the map's part.
    var before = select(vec3(1.0), vec3(0.0), since.x > 0.0);
    let count_before = select(0u, count, since.x > 0.0);
    for (var i = 0u; i < count_before; i += 1u) {
        let texel = taps.middle + vec2(f32(i % 3u), f32(i / 3u)) - 1.0;
        before += light_before(view, texel, since) * tap_weight(taps, i);
    }
    let share = behind / max(before, vec3(LEAST));
    let at_map = mix(around, select(min(share, vec3(1.0)), share, HAS_GAIN), relied_on(before));
    return sum + passed * select(vec3(1.0), at_map, is_near);
}

fn receive_light(light: GpuLight, index: u32, view: GpuView, at: vec3<f32>, point: vec3<f32>, normal: vec3<f32>, bias: f32) -> vec3<f32> {
    // Levels hold all casters: receivers that only some casters tint read the map.
    let takes_all = receives == RECEIVES_CURVE || receives == RECEIVES_NEAREST;
    if has_area(light) && takes_all {
        return receive_area(light, index, view, at, point, normal, bias);
    }
    return receive(light, view, at, bias);
}
