// Light depths of depth keys along the rays of four texels in a column. With order-dependent blending, keys
// are by distance.

import package::features::HAS_OVER;
import package::records::tile_rect::depth_of_key;
import package::records::view::GpuView;

var<private> key_start: vec4<f32>; // light depths of keys 0 and 1
var<private> key_end: vec4<f32>;

fn start_keys(view: GpuView, texel: vec2<f32>) {
    key_start = keyed_depths(view, texel + 0.5, 0.0);
    key_end = keyed_depths(view, texel + 0.5, 1.0);
}

fn keyed_depths(view: GpuView, texel: vec2<f32>, key: f32) -> vec4<f32> {
    return vec4(
        depth_of_key(view, texel, key),
        depth_of_key(view, texel + vec2(0.0, 1.0), key),
        depth_of_key(view, texel + vec2(0.0, 2.0), key),
        depth_of_key(view, texel + vec2(0.0, 3.0), key),
    );
}

// Least light depths of the hits of a caster whose key is `front` of the largest.
fn front_depths(front: f32) -> vec4<f32> {
    return select(vec4(front), key_start + front * (key_end - key_start), HAS_OVER);
}
