// Depths of opaque triangles that are too small for tiles.

import package::bind::read::small_depths;
import package::features::HAS_SMALL;
import package::records::view::{GpuView, TILE_SIZE};

// Least depth of these triangles at a texel of the view's map, 1 for none.
fn small_depth(view: GpuView, texel: vec2<u32>) -> f32 {
    if !HAS_SMALL {
        return 1.0;
    }
    let first = view.first_tile * TILE_SIZE * TILE_SIZE;
    return bitcast<f32>(small_depths[first + texel.y * view.tiles_x * TILE_SIZE + texel.x]);
}
