// Look-up of the light that glass throws. CPU reference: crates/gobo-reference/src/shading/thrown.rs.

import package::bind::read::caustics;
import package::bind::sampled::opaques;
import package::caustics::glass::{NEAR_SURFACE, caustic_light};
import package::records::light::{GpuLight, shadow_view};

// Share of a light at a point, of which its map passes `straight`: where the point is on the opaque surface,
// with the light that lands there, and without light that was thrown elsewhere.
fn with_thrown(light: GpuLight, point: vec3<f32>, straight: vec3<f32>) -> vec3<f32> {
    // Before the texels stands the index of each view's first texel, or 0.
    let first = caustics[light.first_view].x;
    if light.view_count == 0u || first == 0u {
        return straight;
    }
    let view = shadow_view(light.first_view);
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
        if all(at >= vec2(0.0)) && all(at < view.size) {
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
    if whole <= 0.0 {
        return straight;
    }
    let mean = sum / whole;
    return straight * (1.0 - mean.w) + mean.rgb;
}
