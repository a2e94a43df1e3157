// Light depths of depth keys along the rays of an invocation's texels. With order-dependent blending, keys
// are distances.

import package::features::{HAS_OVER, unrolled};
import package::records::tile_rect::depth_of_key;
import package::records::view::GpuView;
import choice::rows::{ROW_COUNT, Rows, with_row};

var<private> key_start: Rows; // light depths of keys 0 and 1
var<private> key_end: Rows;

fn start_keys(view: GpuView, texel: vec2<f32>) {
    for (var i = 0u; i < unrolled(ROW_COUNT); i += 1u) {
        let middle = texel + vec2(0.5, f32(i) + 0.5);
        key_start = with_row(key_start, i, depth_of_key(view, middle, 0.0));
        key_end = with_row(key_end, i, depth_of_key(view, middle, 1.0));
    }
}

// Least light depths of the hits of a caster with key `front`, as a share of the largest key.
fn front_depths(front: f32) -> Rows {
    return select(Rows(front), key_start + front * (key_end - key_start), HAS_OVER);
}
