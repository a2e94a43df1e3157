// A pass of a separable filter: an accumulator sums the texels in a window along a row or a column. One
// invocation per texel of a view. Rust: src/stage/blur.rs, src/stage/soften.rs.

import choice::accumulator::{add, start, store};
import choice::window::window;
import package::bind::uniform::views;

override COLUMN: bool = false; // else a row

@compute @workgroup_size(8, 8)
fn filter_window(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    let size = vec2<i32>(view.size);
    if any(texel >= size) {
        return;
    }
    let along = select(vec2(1, 0), vec2(0, 1), COLUMN);
    let at = vec2<i32>(view.origin) + texel;
    let before = dot(texel, along);
    let behind = dot(size, along) - 1 - before;
    let ends = window(before, behind);
    var sum = start(view, at);
    for (var i = ends.x; i <= ends.y; i += 1) {
        sum = add(sum, view, at + along * clamp(i, -before, behind), i);
    }
    store(view, at, sum);
}
