// Soft shadow of an area light by percentage-closer soft shadows (Fernando 2005) on the prefiltered levels of
// a map: from the light on, from the widest spots to the sharpest. Truth: tests/common/area_truth.rs.

import package::records::area::{area_of, level_map, leveled_view};
import package::records::light::GpuLight;
import package::records::view::GpuView;
import package::shade::level_light::{NEVER, light_of_level, next_occluder};
import package::shade::lifted::{Lifted, Receiver};
import package::shade::receiver::is_solid;
import package::shade::spot::{
    FADE, SHARP, WIDEST, box_of_level, box_widths, fade_at, receiver_end, set_spot, spot_at,
    spot_bias, spot_center,
};
import package::shade::taps::map_taps;
import package::sums::sums::blackened;

// Weight of a level's result, per light before the level, up to 1.
const EVIDENCE: f32 = 300.0;
// Weight of the colour in the widest window, per light that it lacks below CLEAR, up to 1: clear filters
// alone hide nothing.
const HIDING: f32 = 8.0;
const CLEAR: f32 = 0.9;
// Least light that a search for occluders relies on.
const MIN_OPEN: f32 = 0.25;
// Distance of texels' centres from the middle of a block of the first level [blocks].
const AROUND: f32 = 0.25;
// Least light to divide by.
const MIN: f32 = 1e-4;

fn relied_on(before: vec3<f32>) -> vec3<f32> {
    return clamp(before * EVIDENCE, vec3(0.0), vec3(1.0));
}

fn brightest(light: vec3<f32>) -> f32 {
    return max(light.x, max(light.y, light.z));
}

// Share of the light that passes occluders, with the colour of their `widest` window as far as something
// hides a part of it: light past that part reaches the receiver through the filters around, of which a
// narrower window holds too few in the middle of the hidden part, and too many beside it. `left`: light
// behind all occluders, in the widest window.
fn colored_share(share: vec3<f32>, widest: vec3<f32>, left: vec3<f32>) -> vec3<f32> {
    let most = brightest(widest);
    let is_lit = clamp(brightest(left) * EVIDENCE, 0.0, 1.0);
    let hides = clamp((CLEAR - brightest(left)) * HIDING, 0.0, 1.0) * is_lit;
    return mix(share, widest * (brightest(share) / max(most, MIN)), hides);
}

// The finest level whose blocks are large enough for a spot; 0 for the map.
fn level_of(texels: f32, last: u32) -> u32 {
    let near = u32(clamp(ceil(log2(max(texels, SHARP) / WIDEST)), 1.0, 12.0));
    // Corrects the rounding of the logarithm.
    let up = select(near, near + 1u, texels > WIDEST * f32(1u << near));
    let enough = select(up, up - 1u, (up > 1u) & (texels <= WIDEST * f32(1u << (up - 1u))));
    return select(min(enough, last), 0u, texels <= SHARP);
}

// In place of a level: no level is before.
const FROM_LIGHT: u32 = 31u;

// Fade from the depths of coarser levels into those of a level, or of the map, which is level 0.
fn fade_into(level: u32) -> vec2<f32> {
    return select(fade_at(WIDEST * f32(1u << level)), vec2(-1.0), level == FROM_LIGHT);
}

// Light past the occluders of the levels, and where the map continues.
struct Leveled {
    passed: vec3<f32>,
    hidden: vec3<f32>, // light before occluders of levels that no light reaches, which therefore know none
    hidden_from: u32,  // the first of these levels, or FROM_LIGHT
    hidden_to: u32,    // the last of them; 0 for none
    since: vec2<f32>,  // fade into the map
    near: f32,         // first depth of the map's occluders behind it; NEVER for none
    touches: bool,     // filters alone touch the receiver
    number: u32,       // of the leveled view
    last: u32,         // its coarsest level; 0: no level is asked
}

fn through_levels(light: GpuLight, index: u32, view: GpuView, receiver: Receiver, lifted: Lifted) -> Leveled {
    let area = area_of(light);
    let leveled = area.first_leveled + index - light.first_view;
    let taps = map_taps(view, lifted.point);
    let is_lit = taps.reaches & (taps.z <= 1.0 + lifted.bias / (view.far - view.near));
    let last = select(0u, leveled_view(leveled).y, is_lit);
    set_spot(view, area, receiver, lifted.bias);
    // Beyond the far plane nothing is lit; beside the map everything is.
    var passed = vec3(select(1.0, 0.0, taps.reaches & !is_lit));
    var hidden = vec3(0.0);
    var hidden_from = FROM_LIGHT;
    var hidden_to = 0u;
    var entered = FROM_LIGHT; // level into which the one before fades
    var number = last;
    var rest_next = NEVER; // next occluder in the window of the level before
    var near_cue = NEVER;  // first occluder that is left to the map, in a wide window
    if number > 0u {
        loop {
            // The occluder that the level before left over is followed where it fades into the next level or
            // the map. Else ever finer levels are asked, because coarse blocks mix occluders before the
            // receiver with surfaces behind it. Where no light is left in them, they know nothing, and the
            // wider window is believed.
            var cue = rest_next;
            let rest = min(level_of(spot_at(cue), last), number);
            var is_known = (cue != NEVER) & ((rest == number) | (rest == 0u));
            var above = min(select(rest, number, cue == NEVER) + 1u, last);
            rest_next = select(NEVER, cue, is_known);
            loop {
                let map = level_map(view, leveled, above);
                let found = next_occluder(map, fade_into(entered).x, 0.0, 0.0, !is_known);
                is_known = is_known | ((cue != NEVER) & (found.open < MIN_OPEN));
                let is_none = (found.depth == NEVER) & !is_known;
                cue = select(cue, found.depth, (found.depth != NEVER) & !is_known);
                let level = min(level_of(spot_at(cue), last), number);
                number = select(level, select(above - 2u, 0u, cue == NEVER), is_none);
                if is_known | (number == 0u) | ((number + 1u >= above) & !is_none) {
                    break;
                }
                above = number + 1u;
            }
            if number == 0u {
                near_cue = cue;
                break;
            }
            let map = level_map(view, leveled, number);
            // Behind skipped levels, the rest of an occluder in the last fade counts as before: its spot is
            // far wider than this window.
            entered = select(number, FROM_LIGHT, entered == FROM_LIGHT);
            let spot = min(spot_at(cue), WIDEST * (1.0 + FADE) * map.edge);
            let widest = box_widths(box_of_level(map.edge), spot);
            let light = light_of_level(map, widest, fade_into(entered), fade_into(number - 1u));
            let known = relied_on(light.before);
            let left = min(light.before - light.taken, light.most);
            let divisor = max(light.before, vec3(MIN));
            let behind = max(light.behind, vec3(0.0));
            let share = colored_share(max(left / divisor, vec3(0.0)), behind / divisor, behind);
            let unknown = passed * (1.0 - known);
            let is_hidden = any(unknown > vec3(0.0));
            hidden_from = select(hidden_from, entered, is_hidden & (hidden_to == 0u));
            hidden_to = select(hidden_to, number, is_hidden);
            hidden += unknown;
            passed = blackened(passed * known * share);
            rest_next = light.next;
            number -= 1u;
            entered = number;
            if (number == 0u) | all(passed <= vec3(0.0)) {
                break;
            }
        }
    }
    // If levels were skipped, the rest of an occluder in the last fade has a spot far wider than the map's
    // texels: it counts as before.
    let start = fade_into(entered);
    let since = select(start, max(start, vec2(fade_into(0u).x)), entered != FROM_LIGHT);
    // The map's look-up decides which filters within the bias tint an opaque receiver.
    let beyond = select(0.0, 2.0 * spot_bias, is_solid);
    let is_asked = (last > 0u) & (rest_next == NEVER);
    let near_next = next_occluder(level_map(view, leveled, 1u), since.x, AROUND, beyond, is_asked).depth;
    let touches = (near_next != NEVER) & is_solid & (near_next > receiver_end(spot_center, 0.0));
    let is_near = any(passed > vec3(0.0)) & !touches;
    let near = select(NEVER, min(min(rest_next, near_next), near_cue), is_near);
    return Leveled(passed, hidden, hidden_from, hidden_to, since, near, touches, leveled, last);
}
