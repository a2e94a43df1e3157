// Light that arrives at a point through the shadow maps. CPU reference: src/reference/shading/receive.rs.

import choice::source::receive_light;
import package::bind::sampled::{filters, nearests};
import package::curve::light::curve_light;
import package::features::{BARE_FIRST, HAS_FILTERS, NODES};
import package::records::light::{GpuLight, LIGHT_DIRECTIONAL, LIGHT_SPOT, shadow_part, shadow_view};
import package::records::material::{RECEIVES_CURVE, RECEIVES_OPAQUE, RECEIVES_OTHERS};
import package::records::view::{GpuView, PART_FACE, PART_WINDOW};
import package::shade::bare::{Bare, NO_CASTER, receive_bare, solid_depths};
import package::shade::receiver::{is_tinted, receives};
import package::shade::taps::{
    SPLINE_REACH, beyond_spline, filter_of, filter_tap, map_taps, next_rotation, pixel_rotation,
};
import package::shade::tint::{set_plane, tint_depth};

// Least cosine of a slope: 86 degrees.
const MIN_INCIDENCE: f32 = 0.0625;

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

// `point`: that of set_plane, offset along the normal.
fn receive(light: GpuLight, view: GpuView, point: vec3<f32>, bias: f32) -> vec3<f32> {
    let taps = map_taps(view, point);
    let own = filter_of(light);
    let depth_bias = bias / (view.far - view.near);
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

// The point offset along `normal` by the depth that the slope spans within the filter; `sine` of the angle
// between the normal and the direction to the light.
fn lifted(light: GpuLight, texel: f32, point: vec3<f32>, normal: vec3<f32>, sine: f32) -> vec3<f32> {
    let reach = light.normal_bias + 0.5 + beyond_spline(light); // [texels]
    return point + normal * (reach * sine * texel);
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

// Least light that any shadow of the light lets through, per channel. `normal` is on the light's side, zero
// without a surface; `reach`: distance that a caster in the maps may be off the point [m]. Where branches
// cost what they skip, one loop reads fewer maps than a branch for each kind.
fn shadow(light: GpuLight, point: vec3<f32>, normal: vec3<f32>, toward: vec3<f32>, reach: f32) -> vec3<f32> {
    let cosine = dot(normal, toward);
    let sine = sqrt(max(1.0 - cosine * cosine, 0.0));
    // Without a normal there is no slope.
    let slope = light.slope_bias * dot(normal, normal) * sine / max(cosine, MIN_INCIDENCE);
    let face = cube_face(point - light.position);
    let end = light.first_view + light.view_count;
    var is_own = true;     // a further shadow can only take light
    var least = vec3(1.0); // of the shadows so far
    var sum = vec3(0.0);   // of the windows of this shadow
    var rest = 1.0;
    var index = light.first_view;
    if index < end {
        loop {
            var view: GpuView;
            var at: vec3<f32>;
            var share: f32;
            var bias = light.bias + reach;
            var last: u32; // last view of this shadow
            loop {
                index += select(0u, face, shadow_part(index) == PART_FACE);
                view = shadow_view(index);
                let texel = texel_size(view, point);
                at = lifted(light, texel, point, normal, sine);
                if HAS_FILTERS {
                    bias = light.bias + reach + slope * texel;
                }
                share = select(1.0, window_share(light, view, at), view.part == PART_WINDOW);
                last = index + view.part_count - 1u - view.part_index;
                if share > 0.0 || index >= last {
                    break;
                }
                index += 1u;
            }
            set_plane(view, point, normal);
            sum += receive_light(light, index, view, at, point, normal, bias) * (rest * share);
            rest *= 1.0 - share;
            let is_done = rest <= 0.0 || index == last || view.part == PART_FACE;
            let passed = sum / max(1.0 - rest, 1e-6);
            let less = mix(least, select(min(least, passed), passed, is_own), 1.0 - rest);
            least = select(least, less, is_done);
            sum = select(sum, vec3(0.0), is_done);
            rest = select(rest, 1.0, is_done);
            is_own = is_own && !is_done;
            index = select(index, last, is_done) + 1u;
            if index >= end {
                break;
            }
        }
    }
    return least;
}
