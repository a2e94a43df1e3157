// Light that arrives at a point through the shadow maps. CPU reference: src/reference/shading/receive.rs.

import choice::aside::{aside, lay_aside};
import choice::source::receive_light;
import package::bind::sampled::{filters, nearests};
import package::curve::light::curve_light;
import package::features::{BARE_FIRST, HAS_FILTERS, NODES};
import package::records::light::{GpuLight, LIGHT_DIRECTIONAL, LIGHT_SPOT, light_record, shadow_part, shadow_view};
import package::records::material::{RECEIVES_CURVE, RECEIVES_OPAQUE, RECEIVES_OTHERS};
import package::records::view::{GpuView, PART_FACE, PART_WINDOW};
import package::shade::asides::{ASIDE_LEAST, ASIDE_NORMAL, ASIDE_POINT, ASIDE_SUM, ASIDE_VIEWS};
import package::shade::bare::{Bare, NO_CASTER, receive_bare, solid_depths};
import package::shade::receiver::{is_tinted, receives};
import package::shade::taps::{
    SPLINE_REACH, beyond_spline, filter_of, filter_tap, map_taps, next_rotation, pixel_rotation,
};
import package::shade::tint::{set_plane, tint_depth};

// Least cosine of a slope: 86 degrees.
const MIN_INCIDENCE: f32 = 0.0625;

// With the index of a shadow's last view: whether it is complete, and whether it is the light's own.
const WHOLE_BIT: u32 = 0x80000000u;
const OWN_BIT: u32 = 0x40000000u;
const INDEX_MASK: u32 = 0x3fffffffu;

fn bits_of(xyz: vec3<f32>, w: f32) -> vec4<u32> {
    return bitcast<vec4<u32>>(vec4(xyz, w));
}

fn floats_of(bits: vec4<u32>) -> vec4<f32> {
    return bitcast<vec4<f32>>(bits);
}

// The receiver's plane in a view.
fn set_own_plane(view: GpuView) {
    set_plane(view, floats_of(aside(ASIDE_POINT)).xyz, floats_of(aside(ASIDE_NORMAL)).xyz);
}

// Light through one texel to light depth z, by the rules of the receiver. Texels outside the view's map are
// clamped to its border.
fn receive_texel(view: GpuView, texel: vec2<f32>, z: f32, bias: f32) -> vec3<f32> {
    let own = clamp(texel, vec2(0.0), view.size - 1.0);
    let tint_z = tint_depth(view, own + 0.5, z, bias);
    let at = view.origin + vec2<u32>(own);
    let solid = solid_depths(view, at);
    // Curves have no owner tags.
    if NODES > 0u && (receives == RECEIVES_CURVE || receives == RECEIVES_OTHERS) {
        return select(curve_light(view, at, tint_z), vec3(0.0), vec3(z) > solid + bias);
    }
    let nearest = textureLoad(nearests, at, view.layer, 0).r;
    let filtered = textureLoad(filters, at, view.layer, 0);
    let whose = select(is_tinted(filtered, nearest), receives != RECEIVES_OPAQUE, NODES > 0u);
    let tinted = tint_z > nearest && nearest < NO_CASTER && whose;
    let passed = select(vec3(1.0), filtered.rgb, tinted);
    return select(passed, vec3(0.0), vec3(z) > solid + bias);
}

fn receive(light: GpuLight, view: GpuView, lifted: Lifted) -> vec3<f32> {
    set_own_plane(view);
    let taps = map_taps(view, lifted.point);
    let own = filter_of(light);
    let depth_bias = lifted.bias / (view.far - view.near);
    var sum = vec3(0.0);
    var rotation = pixel_rotation;
    // The loop count is not constant: compilers would unroll it, with the whole look-up of a texel.
    var count = select(0u, own.count, taps.reaches);
    var bare = Bare(vec3(1.0), !taps.reaches);
    if BARE_FIRST && NODES == 0u {
        bare = receive_bare(own, taps, count, view, depth_bias);
        count = select(count, 0u, bare.is_all);
    }
    var i = 0u;
    // Tested at its end: llvmpipe executes a body once more where the test comes first.
    if count > 0u {
        loop {
            let tap = filter_tap(own, taps, i, rotation);
            sum += receive_texel(view, tap.texel, taps.z, depth_bias) * tap.weight;
            rotation = next_rotation(rotation);
            i += 1u;
            if i >= count {
                break;
            }
        }
    }
    return select(vec3(1.0), select(sum, bare.light, bare.is_all), taps.reaches);
}

// Face of a cube that contains the direction `away` from its centre.
fn cube_face(away: vec3<f32>) -> u32 {
    let size = abs(away);
    if size.x >= size.y && size.x >= size.z {
        return select(1u, 0u, away.x > 0.0);
    }
    if size.y >= size.z {
        return select(3u, 2u, away.y > 0.0);
    }
    return select(5u, 4u, away.z > 0.0);
}

struct Incoming {
    toward: vec3<f32>, // direction to the light, unit
    color: vec3<f32>,  // irradiance at normal incidence, before shadows
}

fn incoming(light: GpuLight, point: vec3<f32>) -> Incoming {
    if light.kind == LIGHT_DIRECTIONAL {
        return Incoming(-light.direction, light.color);
    }
    let away = point - light.position;
    let square = max(dot(away, away), 1e-4);
    let ray = away * inverseSqrt(square);
    // Fades out towards the end of its range: glTF KHR_lights_punctual, Karis 2013.
    let part = square * light.per_range2;
    let window = max(1.0 - part * part, 0.0);
    var color = light.color / square * (window * window);
    if light.kind == LIGHT_SPOT {
        color *= smoothstep(light.cone_outer, light.cone_inner, dot(ray, light.direction));
    }
    return Incoming(-ray, color);
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

// The point of a look-up lifted off its surface, as a view needs it.
struct Lifted {
    point: vec3<f32>,
    bias: f32, // [m]
}

fn lifted_point(view: GpuView) -> Lifted {
    let place = floats_of(aside(ASIDE_POINT));
    let surface = floats_of(aside(ASIDE_NORMAL));
    let texel = texel_size(view, place.xyz);
    let point = place.xyz + surface.xyz * (surface.w * texel);
    if HAS_FILTERS {
        return Lifted(point, place.w + floats_of(aside(ASIDE_LEAST)).w * texel);
    }
    return Lifted(point, place.w);
}

// Weight of a window at a point: it falls towards the border, and is 0 outside.
fn window_share(light: GpuLight, view: GpuView, point: vec3<f32>) -> f32 {
    let p = (view.view_from_world * vec4(point, 1.0)).xyz;
    let spread = view.scale / select(1.0, max(-p.z, 1e-6), view.perspective > 0.0);
    let place = vec2(p.x, -p.y) * spread + view.size * 0.5;
    let inner = min(place, view.size - place);
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
fn shadow(own: GpuLight, number: u32, point: vec3<f32>, normal: vec3<f32>, toward: vec3<f32>, reach: f32) -> vec3<f32> {
    let cosine = dot(normal, toward);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    // Without a normal there is no slope.
    let slope = own.slope_bias * dot(normal, normal) * sine / max(cosine, MIN_INCIDENCE);
    lay_aside(ASIDE_POINT, bits_of(point, own.bias + reach));
    lay_aside(ASIDE_NORMAL, bits_of(normal, lift(own) * sine));
    lay_aside(ASIDE_SUM, bits_of(vec3(0.0), 1.0));
    lay_aside(ASIDE_LEAST, bits_of(vec3(1.0), slope));
    var light = own;
    var index = own.first_view;
    var is_own = true; // a further shadow can only take light
    if own.view_count > 0u {
        loop {
            let place = floats_of(aside(ASIDE_POINT));
            let face = cube_face(place.xyz - light.position);
            var view: GpuView;
            var lifted: Lifted;
            var share: f32;
            var last: u32; // last view of this shadow
            loop {
                index += select(0u, face, shadow_part(index) == PART_FACE);
                view = shadow_view(index);
                lifted = lifted_point(view);
                share = select(1.0, window_share(light, view, lifted.point), view.part == PART_WINDOW);
                last = index + view.part_count - 1u - view.part_index;
                if share > 0.0 || index >= last {
                    break;
                }
                index += 1u;
            }
            let is_whole = index == last || view.part == PART_FACE;
            let flags = select(0u, WHOLE_BIT, is_whole) | select(0u, OWN_BIT, is_own);
            lay_aside(ASIDE_VIEWS, vec4(index, last | flags, bitcast<u32>(share), number));
            let received = receive_light(light, index, view, lifted);
            let views = aside(ASIDE_VIEWS);
            let part = bitcast<f32>(views.z);
            let so_far = floats_of(aside(ASIDE_SUM));
            let least = floats_of(aside(ASIDE_LEAST));
            let sum = so_far.xyz + received * (so_far.w * part);
            let rest = so_far.w * (1.0 - part);
            let is_done = rest <= 0.0 || (views.y & WHOLE_BIT) != 0u;
            is_own = (views.y & OWN_BIT) != 0u;
            let passed = sum / max(1.0 - rest, 1e-6);
            let less = mix(least.xyz, select(min(least.xyz, passed), passed, is_own), 1.0 - rest);
            lay_aside(ASIDE_LEAST, bits_of(select(least.xyz, less, is_done), least.w));
            lay_aside(ASIDE_SUM, bits_of(select(sum, vec3(0.0), is_done), select(rest, 1.0, is_done)));
            is_own = is_own && !is_done;
            index = select(views.x, views.y & INDEX_MASK, is_done) + 1u;
            light = light_record(views.w);
            if index >= light.first_view + light.view_count {
                break;
            }
        }
    }
    return floats_of(aside(ASIDE_LEAST)).xyz;
}
