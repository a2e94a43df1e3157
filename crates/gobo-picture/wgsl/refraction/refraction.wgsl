// refraction: the scene behind glass, displaced and blurred. CPU reference:
// crates/gobo-reference/src/refraction.rs. Rust: crates/gobo-picture/src/stage/refraction.rs.

import package::bind::picture_in::{behinds, bends, composited};
import package::bind::picture_out::{pixels, radiance};
import package::shade::tone::on_screen;

// Place where a pixel sees the scene behind its panes: texels of `bends`, zero where it is seen straight.
struct Bend {
    aside: vec2<f32>,  // from the pixel [pixels]
    blur: f32,         // radius [pixels]
    pane: f32,         // light depth of the nearest pane
    passed: vec3<f32>, // share of the light behind that reaches the eye
}

fn pack_bend(bend: Bend) -> vec4<u32> {
    return vec4(
        pack2x16float(bend.aside),
        pack2x16float(bend.passed.rg),
        pack2x16float(vec2(bend.passed.b, bend.blur)),
        bitcast<u32>(bend.pane),
    );
}

fn unpack_bend(bits: vec4<u32>) -> Bend {
    let last = unpack2x16float(bits.z);
    return Bend(unpack2x16float(bits.x), last.y, bitcast<f32>(bits.w), vec3(unpack2x16float(bits.y), last.x));
}

// Least difference in light depth at which a surface in front of a pane hides the scene behind it: depths are
// halves.
const PANE_SLACK: f32 = 0.001;

fn of_level(texel: vec2<i32>, level: i32, last: vec2<i32>) -> vec4<f32> {
    return textureLoad(behinds, clamp(texel, vec2(0), last), level);
}

// Quadratic B-spline over 3 x 3 texels of a level. `position` [pixels].
fn smooth_level(position: vec2<f32>, level: i32) -> vec3<f32> {
    let last = vec2<i32>(textureDimensions(behinds, level)) - 1;
    let at = position * exp2(-f32(level));
    let middle = floor(at);
    let off = at - middle - 0.5;
    let before = 0.5 * (0.5 - off) * (0.5 - off);
    let after = 0.5 * (0.5 + off) * (0.5 + off);
    var sum = vec3(0.0);
    for (var i = 0; i < 9; i += 1) {
        let step = vec2(i % 3, i / 3) - 1;
        let aside = select(select(1.0 - before - after, before, step < vec2(0)), after, step > vec2(0));
        sum += of_level(vec2<i32>(middle) + step, level, last).rgb * (aside.x * aside.y);
    }
    return sum;
}

// Light around a position [pixels], blurred over a radius [pixels].
fn behind(position: vec2<f32>, blur: f32) -> vec3<f32> {
    let top = f32(textureNumLevels(behinds) - 1u);
    let level = clamp(log2(max(blur, 0.5) * 2.0), 0.0, top);
    let low = i32(level);
    let part = level - f32(low);
    var light = smooth_level(position, low);
    if part > 0.0 {
        light = mix(light, smooth_level(position, low + 1), part);
    }
    return light;
}

// refraction, apply: adds the light behind glass that is seen refracted or blurred. One invocation per pixel.
@compute @workgroup_size(8, 8)
fn refraction_apply(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(composited);
    if any(id.xy >= size) {
        return;
    }
    let seen = textureLoad(composited, id.xy, 0);
    var light = seen.rgb;
    let bits = textureLoad(bends, id.xy, 0);
    if any(bits != vec4(0u)) {
        let bend = unpack_bend(bits);
        let last = vec2<i32>(size) - 1;
        let pixel = vec2<f32>(id.xy) + 0.5;
        let found = clamp(pixel + bend.aside, vec2(0.5), vec2<f32>(size) - 0.5);
        // A surface in front of the glass is not seen through it.
        let hides = of_level(vec2<i32>(found), 0, last).a < bend.pane - PANE_SLACK;
        light += bend.passed * behind(select(found, pixel, hides), bend.blur);
    }
    textureStore(radiance, id.xy, vec4(light, seen.w));
    pixels[id.y * size.x + id.x] = on_screen(light);
}
