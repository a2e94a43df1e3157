// Soft shadow of an area light by percentage-closer soft shadows (Fernando 2005) on the prefiltered levels of
// a map: from the light on, from the widest spots to the sharpest. Truth: tests/common/area_truth.rs.

import package::curve::node::DEPTHS;
import package::records::area::{area_of, level_map, leveled_view};
import package::records::light::GpuLight;
import package::records::view::GpuView;
import package::shade::asides::{ASIDE_HIDDEN, ASIDE_NORMAL, ASIDE_PASSED, ASIDE_POINT, bits_of, floats_of};
import package::shade::level_light::{
    NEVER, evaluate_level, least_open, level_light, next_occluder, search_rows,
};
import package::shade::lifted::Lifted;
import package::shade::receiver::is_solid;
import package::shade::spot::{FADE, SHARP, WIDEST, fade_at, receiver_end, set_spot, spot_at, spot_center};
import package::shade::taps::map_taps;
import package::sums::sums::blackened;
import choice::aside::{aside, forget_asides, lay_aside};

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
// Bit beside the number of a level that is laid aside: whether filters alone touch the receiver.
const TOUCH_BIT: u32 = 0x80000000u;

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
    let enough = select(up, up - 1u, up > 1u && texels <= WIDEST * f32(1u << (up - 1u)));
    return select(min(enough, last), 0u, texels <= SHARP);
}

// Result of the levels, for the map. Laid aside: the light behind the levels' occluders, with the start of
// the fade behind which the first of them holds nothing, and the light past such occluders, with the last of
// those levels.
struct Leveled {
    since: vec2<f32>, // fade into the map
    near: f32,        // first depth of the map's occluders behind it; NEVER for none, or if filters touch
    hidden_end: f32,  // end of the fade that is laid aside
    number: u32,      // of the leveled view
    last: u32,        // first depth of the map's occluders behind it; NEVER for none, or if filters touch
}

fn through_levels(light: GpuLight, index: u32, view: GpuView, lifted: Lifted) -> Leveled {
    let area = area_of(light);
    let leveled = area.first_leveled + index - light.first_view;
    let taps = map_taps(view, lifted.point);
    let is_lit = taps.reaches && taps.z <= 1.0 + lifted.bias / (view.far - view.near);
    // 0: no level is asked.
    let last = select(0u, leveled_view(leveled).y, is_lit);
    set_spot(
        view,
        light,
        area,
        floats_of(aside(ASIDE_POINT)).xyz,
        floats_of(aside(ASIDE_NORMAL)).xyz,
        lifted.bias,
    );
    // Loop counts are not constant, so that compilers do not unroll.
    let four = select(0u, 4u + 4u * u32(search_rows()), last > 0u);
    // Beyond the far plane nothing is lit; beside the map everything is.
    lay_aside(ASIDE_PASSED, bits_of(vec3(select(1.0, 0.0, taps.reaches && !is_lit)), 0.0));
    lay_aside(ASIDE_HIDDEN, vec4(0u));
    var hidden_end = 0.0;
    var since = vec2(-1.0); // fade of the level before
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
            var is_known = cue != NEVER && (rest == number || rest == 0u);
            let blocks = select(four, 0u, is_known);
            var above = min(select(rest, number, cue == NEVER) + 1u, last);
            rest_next = select(NEVER, cue, is_known);
            loop {
                let next = next_occluder(level_map(view, leveled, above), blocks, since.x, 0.0, 0.0);
                is_known = is_known || (cue != NEVER && least_open < MIN_OPEN);
                let is_none = next == NEVER && !is_known;
                cue = select(cue, next, next != NEVER && !is_known);
                let found = min(level_of(spot_at(cue), last), number);
                number = select(found, select(above - 2u, 0u, cue == NEVER), is_none);
                if is_known || number == 0u || (number + 1u >= above && !is_none) {
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
            since = select(since, max(since, fade_at(WIDEST * map.edge)), since.x > 0.0);
            let to = fade_at(select(WIDEST * map.edge * 0.5, SHARP, number == 1u));
            evaluate_level(map, min(spot_at(cue), WIDEST * (1.0 + FADE) * map.edge), since, to);
            let known = relied_on(level_light.before);
            let left = min(level_light.before - level_light.taken, level_light.most);
            let divisor = max(level_light.before, vec3(MIN));
            let behind = max(level_light.behind, vec3(0.0));
            let share = colored_share(max(left / divisor, vec3(0.0)), behind / divisor, behind);
            forget_asides(number);
            let lit = floats_of(aside(ASIDE_PASSED));
            let shaded = aside(ASIDE_HIDDEN);
            let hidden = floats_of(shaded).xyz;
            let unknown = lit.xyz * (1.0 - known);
            let is_hidden = any(unknown > vec3(0.0));
            let is_first = is_hidden && all(hidden == vec3(0.0));
            hidden_end = select(hidden_end, since.y, is_first);
            let passed = blackened(lit.xyz * known * share);
            lay_aside(ASIDE_PASSED, bits_of(passed, select(lit.w, since.x, is_first)));
            let hidden_level = select(shaded.w, number, is_hidden);
            lay_aside(ASIDE_HIDDEN, vec4(bits_of(hidden + unknown, 0.0).xyz, hidden_level));
            rest_next = level_light.next;
            since = to;
            number = select(0u, number - 1u, any(passed > vec3(0.0)));
            if number == 0u {
                break;
            }
        }
    }
    // If levels were skipped, the rest of an occluder in the last fade has a spot far wider than the map's
    // texels: it counts as before.
    since = select(since, max(since, vec2(fade_at(SHARP).x)), since.x > 0.0);
    let blocks = select(four, 0u, rest_next != NEVER);
    // The map's look-up decides which filters within the bias tint an opaque receiver.
    let beyond = select(0.0, 2.0 * lifted.bias / (view.far - view.near) * DEPTHS, is_solid);
    let near_next = next_occluder(level_map(view, leveled, 1u), blocks, since.x, AROUND, beyond);
    let lit = floats_of(aside(ASIDE_PASSED)).xyz;
    let touches = near_next != NEVER && is_solid && near_next > receiver_end(spot_center, 0.0);
    let shaded = aside(ASIDE_HIDDEN);
    lay_aside(ASIDE_HIDDEN, vec4(shaded.xyz, select(shaded.w, shaded.w | TOUCH_BIT, touches)));
    let is_near = any(lit > vec3(0.0)) && !touches;
    let near = select(NEVER, min(min(rest_next, near_next), near_cue), is_near);
    return Leveled(since, near, hidden_end, leveled, last);
}
