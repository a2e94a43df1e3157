// filter, columns: second pass of the blur, and the maps with a grey filter instead of holes. CPU reference:
// src/reference/filter.rs. Rust: src/stage/filter.rs.

import package::bind::sampled::{filters, nearests, opaques, rows};
import package::bind::stored::{soft_filters, soft_nearests, soft_opaques};
import package::bind::uniform::{filter_params, views};
import package::records::opaque_depth::is_dithered;
import package::soften::window::{EMPTY_RUN, add_run, window_weight};

@compute @workgroup_size(8, 8)
fn filter_columns(@builtin(global_invocation_id) id: vec3<u32>) {
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
        let at = vec2(texel.x, clamp(texel.y + i, 0, size.y - 1));
        let run = textureLoad(rows, vec2<i32>(view.origin) + at, view.layer, 0);
        sum = add_run(sum, run, window_weight(i, radius), abs(i));
    }
    let at = view.origin + id.xy;
    let filtered = textureLoad(filters, at, view.layer, 0);
    let nearest = textureLoad(nearests, at, view.layer, 0).r;
    let opaque_depth = textureLoad(opaques, at, view.layer, 0).r;
    let light = vec4(max(filtered.rgb * (1.0 - sum.x), vec3(0.0)), filtered.a);
    let behind = select(sum.z, 1.0, sum.z < 0.0);
    textureStore(soft_filters, at, view.layer, select(filtered, light, sum.x > 0.0));
    textureStore(soft_nearests, at, view.layer, vec4(min(nearest, sum.y)));
    textureStore(soft_opaques, at, view.layer, vec4(select(opaque_depth, behind, is_dithered(opaque_depth))));
}
