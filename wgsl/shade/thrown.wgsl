// Look-up of the light that glass throws. CPU reference: crates/gobo-reference/src/shading/thrown.rs.

import package::bind::read::caustics;
import package::bind::sampled::opaques;
import package::records::glass::{NEAR_SURFACE, caustic_light};
import package::records::light::{GpuLight, shadow_view};
import package::records::view::{GpuView, ROLE_FACE, ROLE_WINDOW};
import package::shade::incoming::cube_face;
import package::shade::shadow::window_share;

// Share of a light at a point, of which its maps pass `straight`: where the point is on the opaque surface,
// with the light that lands there, and without light that was thrown elsewhere.
fn with_thrown(thrown: vec4<f32>, straight: vec3<f32>) -> vec3<f32> {
    return straight * (1.0 - thrown.w) + thrown.rgb;
}

// Share of a light that lands at a point, and the share that was thrown elsewhere.
fn thrown_at(light: GpuLight, point: vec3<f32>) -> vec4<f32> {
    // Before the texels stands the index of each view's first texel, or 0.
    if light.view_count == 0u || caustics[light.first_view].x == 0u {
        return vec4(0.0);
    }
    var index = light.first_view;
    let whole = shadow_view(index);
    let is_cube = whole.role == ROLE_FACE;
    if is_cube {
        let in_view = whole.view_from_world * vec4(point, 1.0);
        index += cube_face((vec4(in_view.xyz, 0.0) * whole.view_from_world).xyz);
    }
    let last = select(light.first_view + whole.role_count - 1u, index, is_cube);
    var sum = vec4(0.0);
    var rest = 1.0;
    loop {
        let view = shadow_view(index);
        var share = 1.0;
        if view.role == ROLE_WINDOW {
            share = window_share(light, view, point);
        }
        if share > 0.0 {
            sum += landed_light(view, caustics[index].x, point) * (rest * share);
            rest *= 1.0 - share;
        }
        index += 1u;
        if (rest <= 0.0) | (index > last) {
            break;
        }
    }
    return sum;
}

// Light that lands around a point of a view, and the share of the straight light there that was thrown
// elsewhere; none off the opaque surface. `first`: of the view's texels.
fn landed_light(view: GpuView, first: u32, point: vec3<f32>) -> vec4<f32> {
    let seen = (view.view_from_world * vec4(point, 1.0)).xyz;
    let texel = select(1.0, -seen.z, view.perspective > 0.0) / view.scale;
    let spread = view.scale / select(1.0, max(-seen.z, 1e-6), view.perspective > 0.0);
    let place = vec2(seen.x, -seen.y) * spread + view.size * 0.5;
    let middle = floor(place);
    let off = place - middle - 0.5;
    let before = 0.5 * (0.5 - off) * (0.5 - off);
    let behind = 0.5 * (0.5 + off) * (0.5 + off);
    var sum = vec4(0.0);
    var whole = 0.0;
    for (var i = 0u; i < 9u; i += 1u) {
        let aside = vec2(f32(i % 3u), f32(i / 3u)) - 1.0;
        let at = middle + aside;
        if all(at >= vec2(0.0)) & all(at < view.size) {
            let pixel = vec2<u32>(at);
            let depth = textureLoad(opaques, view.origin + pixel, view.layer, 0).r;
            let along = view.near + depth * (view.far - view.near);
            if abs(along + seen.z) <= NEAR_SURFACE * texel {
                // Quadratic B-spline, as for maps.
                let ends = select(1.0 - before - behind, before, aside < vec2(0.0));
                let shares = select(ends, behind, aside > vec2(0.0));
                let weight = shares.x * shares.y;
                sum += caustic_light(caustics[first + pixel.y * u32(view.size.x) + pixel.x]) * weight;
                whole += weight;
            }
        }
    }
    return select(vec4(0.0), sum / whole, whole > 0.0);
}
