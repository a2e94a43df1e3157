// Transmittance from an area light to a point: through the levels of a map, and through the map itself.

import choice::aside::{aside, forget_asides, lay_aside};
import package::features::HAS_GAIN;
import package::records::area::has_area;
import package::records::light::{GpuLight, light_record, shadow_view};
import package::records::material::{RECEIVES_CURVE, RECEIVES_NEAREST};
import package::records::view::GpuView;
import package::shade::asides::{ASIDE_HIDDEN, ASIDE_NORMAL, ASIDE_PASSED, ASIDE_VIEWS, bits_of, floats_of};
import package::shade::fade::{fade_between, light_before};
import package::shade::lifted::{Lifted, lifted_point, set_own_plane};
import package::shade::nearest_lit::nearest_lit;
import package::shade::receive::receive_texel;
import package::shade::receiver::receives;
import package::shade::spot::receiver_depth;
import package::shade::taps::{
    FILTER_SPLINE, Filter, SPLINE_REACH, filter_of, filter_tap, map_taps, next_rotation, pixel_rotation,
};
import package::shade::through_levels::{Leveled, MIN, relied_on, through_levels};

fn receive_light(light: GpuLight, index: u32, view: GpuView, lifted: Lifted) -> vec3<f32> {
    // Levels hold all casters: receivers that only some casters tint read the map.
    let takes_all = receives == RECEIVES_CURVE || receives == RECEIVES_NEAREST;
    let is_soft = has_area(light) && takes_all;
    let none = vec3(0.0);
    var leveled = Leveled(vec3(1.0), vec2(-1.0), false, none, vec2(0.0), 0u, 0u, 0u);
    if is_soft {
        leveled = through_levels(light, index, view, lifted);
    }
    return through_map(leveled, is_soft);
}

// Light through what is close to the receiver, from the map itself, and what gets past the occluders that hide
// others. One loop for soft and hard lights, as branches cost llvmpipe what they skip.
fn through_map(leveled: Leveled, is_soft: bool) -> vec3<f32> {
    forget_asides(leveled.last);
    let views = aside(ASIDE_VIEWS);
    let view = shadow_view(views.x);
    let lifted = lifted_point(light_record(views.w), view);
    set_own_plane(view);
    let taps = map_taps(view, lifted.point);
    let reach = lifted.bias / (view.far - view.near);
    let is_lit = taps.reaches && taps.z <= 1.0 + reach;
    var kernel = filter_of(light_record(views.w));
    if is_soft {
        kernel = Filter(FILTER_SPLINE, 9u, 3.0, SPLINE_REACH);
    }
    let fade = fade_between(leveled.since);
    let is_near = select(is_lit, leveled.is_near, is_soft);
    let count = select(0u, kernel.count, select(taps.reaches, is_near, is_soft));
    // A point without a normal was not lifted off its surface.
    let is_bare = is_soft && all(floats_of(aside(ASIDE_NORMAL)).xyz == vec3(0.0));
    var before = vec3(0.0);
    var behind = vec3(0.0);
    var rotation = pixel_rotation;
    var i = 0u;
    if count > 0u {
        loop {
            let tap = filter_tap(kernel, taps, i, rotation);
            let z = select(taps.z, receiver_depth(tap.texel + 0.5), is_bare);
            behind += receive_texel(view, tap.texel, z, reach) * tap.weight;
            before += light_before(view, tap.texel, fade) * tap.weight;
            rotation = next_rotation(rotation);
            i += 1u;
            if i >= count {
                break;
            }
        }
    }
    let share = behind / max(before, vec3(MIN));
    let known = select(vec3(1.0), relied_on(before), is_near);
    let at_map = select(vec3(1.0), select(min(share, vec3(1.0)), share, HAS_GAIN), is_near);
    let unknown = leveled.passed * (1.0 - known);
    let is_hidden = any(unknown > vec3(0.0));
    let is_first = is_hidden && all(leveled.hidden == vec3(0.0));
    let hidden_since = select(leveled.hidden_since, leveled.since, is_first);
    // 0 where nothing is hidden: no level is asked.
    let first = select(leveled.hidden_level, 1u, is_hidden);
    let straight = select(vec3(0.0), leveled.passed * known * at_map, is_lit);
    let past = select(vec3(0.0), leveled.hidden + unknown, is_lit);
    lay_aside(ASIDE_PASSED, bits_of(select(behind, straight, is_soft), 0.0));
    lay_aside(ASIDE_HIDDEN, bits_of(select(vec3(0.0), past, is_soft), 0.0));
    let around = nearest_lit(view, leveled.number, first, leveled.last, hidden_since);
    forget_asides(first);
    let lit = floats_of(aside(ASIDE_PASSED)).xyz + floats_of(aside(ASIDE_HIDDEN)).xyz * around;
    return select(vec3(1.0), lit, taps.reaches);
}
