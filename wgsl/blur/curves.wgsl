// blur, curves: the mean curve of a row's window, then of a column's. CPU reference: src/reference/blur.rs.
// Rust: src/stage/blur.rs.

import choice::below::{open_child, store_nodes, window_texels};
import package::bind::sampled::near_around;
import package::bind::uniform::views;
import package::curve::mean::{find_parts, part_node};
import package::curve::node::curve_layer;
import package::features::NODES;

@compute @workgroup_size(8, 8)
fn blur_curves(@builtin(global_invocation_id) id: vec3<u32>) {
    let view = views[id.z];
    let texel = vec2<i32>(id.xy);
    if any(texel >= vec2<i32>(view.size)) {
        return;
    }
    let at = vec2<i32>(view.origin) + texel;
    let near = textureLoad(near_around, at, view.layer, 0).b;
    // Windows without translucent casters have no children.
    let children = select(window_texels(view, texel), 0u, near >= 1.0);
    let ramps = select(NODES, 0u, near >= 1.0);
    open_child(view, texel, near);
    find_parts(children, ramps, NODES);
    for (var pair = 0u; pair < NODES / 2u; pair += 1u) {
        let first = part_node(2u * pair, children, ramps);
        let second = part_node(2u * pair + 1u, children, ramps);
        store_nodes(at, curve_layer(view.layer, pair), vec4(first, second));
    }
}
