// filter, rows: share of each row's window that dithered surfaces block, and the depth behind them. CPU
// reference: src/reference/filter.rs. Rust: src/stage/filter.rs.

import package::bind::sampled::opaques;
import package::bind::stored::rows;
import package::bind::uniform::{filter_params, views};
import package::records::opaque_depth::is_dithered;
import package::soften::window::{EMPTY_RUN, add_run, window_weight};

@compute @workgroup_size(8, 8)
fn filter_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let size = vec2<i32>(view.size);
    let texel = vec2<i32>(id.xy);
    if any(texel >= size) {
        return;
    }
    // Not by the uniform alone: lavapipe recompiles such a loop for every buffer.
    let radius = select(0, filter_params.radius, textureDimensions(rows).x > 0u);
    var sum = EMPTY_RUN;
    for (var i = -radius; i <= radius; i += 1) {
        let at = vec2(clamp(texel.x + i, 0, size.x - 1), texel.y);
        let depth = textureLoad(opaques, vec2<i32>(view.origin) + at, view.layer, 0).r;
        let run = select(vec4(0.0, 1.0, depth, 0.0), vec4(1.0, depth, -1.0, 1e6), is_dithered(depth));
        sum = add_run(sum, run, window_weight(i, radius), abs(i));
    }
    textureStore(rows, view.origin + id.xy, view.layer, sum);
}
