// blur, rows: the sum of the filter over each row's window, and its weight. CPU reference:
// src/reference/blur.rs. Rust: src/stage/blur.rs.

import package::bind::sampled::{filters, near_around};
import package::bind::stored::rows;
import package::bind::uniform::views;
import package::blur::sight::sees;
import package::blur::window::{gaussian, window_ends};

@compute @workgroup_size(8, 8)
fn blur_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    if any(texel >= vec2<i32>(view.size)) {
        return;
    }
    let at = vec2<i32>(view.origin) + texel;
    let near = textureLoad(near_around, at, view.layer, 0).b;
    let ends = window_ends(texel.x, i32(view.size.x));
    var sum = vec4(0.0);
    for (var i = ends.x; i <= ends.y; i += 1) {
        let there = at + vec2(i, 0);
        let weight = select(0.0, gaussian(i), sees(view, there, near));
        sum += vec4(textureLoad(filters, there, view.layer, 0).rgb, 1.0) * weight;
    }
    textureStore(rows, at, view.layer, sum);
}
