// Where one level hands over to the next, each occluder counts with a share that falls linearly over a range
// of depths. A block's ramp has the mean depth of its texels', and so the same share. Split at one depth,
// ramps of different lengths would have different shares, and the shadow a bright line.

import package::bind::sampled::{curves, filters, nearests, opaques};
import package::bind::uniform::picture_params;
import package::curve::node::{DEPTHS, curve_layer, node_length, node_light, node_start};
import package::features::NODES;
import package::records::view::GpuView;

// A fade: the share falls from 1 at `low` to 0 at `high`.
struct Fade {
    low: f32,
    high: f32,
    slope: f32,
}

fn fade_between(depths: vec2<f32>) -> Fade {
    return Fade(depths.x, depths.y, 1.0 / max(depths.y - depths.x, 1e-3));
}

// Share of the ramp from `start` on, of an inverse length, that counts as before a fade, from the light on;
// of the part up to `stop`.
fn share_before(fade: Fade, start: f32, stop: f32, inverse: f32) -> f32 {
    let inside = clamp(vec2(start, stop), vec2(fade.low), vec2(fade.high));
    let weights = (fade.high - inside) * fade.slope;
    let whole = max(min(stop, fade.low) - start, 0.0);
    return saturate((whole + (inside.y - inside.x) * 0.5 * (weights.x + weights.y)) * inverse);
}

// Share of a surface that counts as before a fade. Depth 1 is none.
fn surface_before(fade: Fade, depth: vec3<f32>) -> vec3<f32> {
    let share = saturate((fade.high - depth * DEPTHS) * fade.slope);
    return select(share, vec3(0.0), depth >= vec3(1.0));
}

// Light behind the nodes of a texel so far, and light before the fade.
var<private> texel_left: vec3<f32>;
var<private> texel_light: vec3<f32>;

fn fade_node(node: vec2<u32>, fade: Fade) {
    let start = node_start(node);
    let length = max(node_length(node), 1.0);
    let light = node_light(node);
    let drop = select(vec3(0.0), texel_left - light, start > 0.0);
    texel_left -= drop;
    texel_light -= drop * share_before(fade, start, start + length, 1.0 / length);
}

// Light of a texel before a fade.
fn light_before(view: GpuView, texel: vec2<f32>, fade: Fade) -> vec3<f32> {
    let at = view.origin + vec2<u32>(clamp(texel, vec2(0.0), view.size - 1.0));
    let depths = textureLoad(opaques, at, view.layer, 0).rgb;
    texel_left = vec3(1.0);
    texel_light = vec3(1.0);
    if NODES > 0u {
        var pair = 0u;
        loop {
            let nodes = textureLoad(curves, at, curve_layer(view.layer, pair), 0);
            fade_node(nodes.xy, fade);
            fade_node(nodes.zw, fade);
            pair += 1u;
            if pair >= NODES / 2u {
                break;
            }
        }
    } else {
        let nearest = textureLoad(nearests, at, view.layer, 0).r;
        texel_left = select(vec3(1.0), textureLoad(filters, at, view.layer, 0).rgb, nearest < 1.0);
        texel_light -= (1.0 - texel_left) * surface_before(fade, vec3(nearest));
    }
    let solid = select(depths.rrr, depths, picture_params.colored != 0u);
    return texel_light - texel_left * surface_before(fade, solid);
}
