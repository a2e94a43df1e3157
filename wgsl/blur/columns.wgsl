// blur, columns: the filter map, blurred, and the nearest depth of the window. CPU reference:
// src/reference/blur.rs. Rust: src/stage/blur.rs.

import package::bind::sampled::{near_around, rows};
import package::bind::stored::{filters, nearests};
import package::bind::uniform::views;
import package::blur::window::{gaussian, window_ends};

@compute @workgroup_size(8, 8)
fn blur_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    if any(texel >= vec2<i32>(view.size)) {
        return;
    }
    let at = vec2<i32>(view.origin) + texel;
    let near = textureLoad(near_around, at, view.layer, 0).rg;
    let ends = window_ends(texel.y, i32(view.size.y));
    var sum = vec4(0.0);
    for (var i = ends.x; i <= ends.y; i += 1) {
        sum += textureLoad(rows, at + vec2(0, i), view.layer, 0) * gaussian(i);
    }
    let light = select(vec3(1.0), sum.rgb / max(sum.w, 1e-30), sum.w > 0.0);
    textureStore(filters, at, view.layer, vec4(light, near.y));
    textureStore(nearests, at, view.layer, vec4(near.x));
}
