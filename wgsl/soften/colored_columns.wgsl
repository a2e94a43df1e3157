// colored, columns: second pass of the blur, and the maps with a coloured filter instead of holes. CPU
// reference: src/reference/filter.rs. Rust: src/stage/colored.rs.

import package::bind::sampled::{filters, nearests, opaques, rows};
import package::bind::stored::{soft_filters, soft_nearests, soft_opaques};
import package::bind::uniform::{filter_params, views};
import package::records::opaque_depth::is_dithered;
import package::soften::window::window_weight;
import package::soften::window_colored::{ColoredRun, EMPTY_COLORED, add_colored};

@compute @workgroup_size(8, 8)
fn colored_columns(@builtin(global_invocation_id) id: vec3<u32>) {
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
        let at = vec2<i32>(view.origin) + vec2(texel.x, clamp(texel.y + i, 0, size.y - 1));
        let shares = textureLoad(rows, at, 2u * view.layer, 0);
        let hole = textureLoad(rows, at, 2u * view.layer + 1u, 0);
        let run = ColoredRun(shares.rgb, shares.a, hole.x, hole.y);
        sum = add_colored(sum, run, window_weight(i, radius), abs(i));
    }
    let at = view.origin + id.xy;
    let filtered = textureLoad(filters, at, view.layer, 0);
    let nearest = textureLoad(nearests, at, view.layer, 0).r;
    let opaque_depth = textureLoad(opaques, at, view.layer, 0).r;
    let light = max(filtered.rgb * (1.0 - sum.blocked), vec3(0.0));
    let behind = select(sum.hole, 1.0, sum.hole < 0.0);
    textureStore(soft_filters, at, view.layer, vec4(select(filtered.rgb, light, sum.blocked > vec3(0.0)), filtered.a));
    textureStore(soft_nearests, at, view.layer, vec4(min(nearest, sum.nearest)));
    textureStore(soft_opaques, at, view.layer, vec4(select(opaque_depth, behind, is_dithered(opaque_depth))));
}
