// blur, nearest depths, columns: the nearest depth of the whole window. CPU reference: src/reference/blur.rs.
// Rust: src/stage/blur.rs.

import package::bind::sampled::near_rows;
import package::bind::stored::near_around;
import package::bind::uniform::views;
import package::blur::window::window_ends;

@compute @workgroup_size(8, 8)
fn blur_near_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    if any(texel >= vec2<i32>(view.size)) {
        return;
    }
    let at = vec2<i32>(view.origin) + texel;
    let ends = window_ends(texel.y, i32(view.size.y));
    var near = textureLoad(near_rows, at, view.layer, 0).rgb;
    for (var i = ends.x; i <= ends.y; i += 1) {
        let other = textureLoad(near_rows, at + vec2(0, i), view.layer, 0).rgb;
        let first = min(near.z, other.z);
        near = vec3(select(near.xy, other.xy, other.x < near.x), first);
    }
    textureStore(near_around, at, view.layer, vec4(near, 0.0));
}
