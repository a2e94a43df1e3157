// colored, rows: share of each row's window that dithered surfaces block per channel, and the depth behind
// them. CPU reference: src/reference/filter.rs. Rust: src/stage/colored.rs.

import package::bind::sampled::colored;
import package::bind::stored::rows;
import package::bind::uniform::{filter_params, views};
import package::soften::window::window_weight;
import package::soften::window_colored::{EMPTY_COLORED, add_colored, colored_run};

@compute @workgroup_size(8, 8)
fn colored_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let size = vec2<i32>(view.size);
    let texel = vec2<i32>(id.xy);
    if any(texel >= size) {
        return;
    }
    // Not by the uniform alone: lavapipe recompiles such a loop for every buffer.
    let radius = select(0, filter_params.radius, textureDimensions(rows).x > 0u);
    var sum = EMPTY_COLORED;
    for (var i = -radius; i <= radius; i += 1) {
        let at = vec2(clamp(texel.x + i, 0, size.x - 1), texel.y);
        let depths = textureLoad(colored, vec2<i32>(view.origin) + at, view.layer, 0).rgb;
        sum = add_colored(sum, colored_run(depths), window_weight(i, radius), abs(i));
    }
    let at = view.origin + id.xy;
    textureStore(rows, at, 2u * view.layer, vec4(sum.blocked, sum.nearest));
    textureStore(rows, at, 2u * view.layer + 1u, vec4(sum.hole, sum.distance, 0.0, 0.0));
}
