// soften, curve rows: summary of the dithered surfaces in each row's window. CPU reference:
// src/reference/curve/soften.rs. Rust: src/stage/filter.rs.

import package::bind::sampled::colored;
import package::bind::stored::rows;
import package::bind::uniform::{filter_params, views};
import package::records::opaque_depth::is_dithered;
import package::soften::curve_run::{CURVE_RUN_LAYERS, CurveRun, EMPTY_CURVE_RUN, add_curve_run};
import package::soften::window::window_weight;

// Run of one texel with opaque depths per channel.
fn curve_run(depths: vec3<f32>, at: vec2<i32>) -> CurveRun {
    let dithered = vec3(is_dithered(depths.r), is_dithered(depths.g), is_dithered(depths.b));
    let blocked = select(vec3(0.0), vec3(1.0), dithered);
    let near = select(vec3(1.0), depths, dithered);
    let far = select(vec3(-1.0), depths, dithered);
    let moments = vec3(dot(blocked, vec3(1.0)), dot(blocked, depths), dot(blocked, depths * depths));
    return CurveRun(
        blocked,
        min(min(near.r, near.g), near.b),
        moments / 3.0,
        max(max(far.r, far.g), far.b),
        select(vec2<f32>(at), vec2(-1.0), all(dithered)),
        select(0.0, 1e6, all(dithered)),
    );
}

@compute @workgroup_size(8, 8)
fn curve_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let size = vec2<i32>(view.size);
    let texel = vec2<i32>(id.xy);
    if any(texel >= size) {
        return;
    }
    // Not by the uniform alone: lavapipe recompiles such a loop for every buffer.
    let radius = select(0, filter_params.radius, textureDimensions(rows).x > 0u);
    var sum = EMPTY_CURVE_RUN;
    for (var i = -radius; i <= radius; i += 1) {
        let at = vec2(clamp(texel.x + i, 0, size.x - 1), texel.y);
        let stored = textureLoad(colored, vec2<i32>(view.origin) + at, view.layer, 0).rgb;
        let depths = select(stored.rrr, stored, filter_params.colored != 0u);
        sum = add_curve_run(sum, curve_run(depths, at), window_weight(i, radius), abs(i));
    }
    let at = view.origin + id.xy;
    let layer = CURVE_RUN_LAYERS * view.layer;
    textureStore(rows, at, layer, vec4(sum.blocked, sum.nearest));
    textureStore(rows, at, layer + 1u, vec4(sum.moments, sum.farthest));
    textureStore(rows, at, layer + 2u, vec4(sum.hole, sum.distance, 0.0));
}
