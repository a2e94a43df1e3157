// Surfaces of masks of the picture's size.

import package::bind::stored::{mask_points, mask_surfaces};

// `packed`: a texel of `mask_points`; `depths`: of the 2 x 2 pixels that contain this one.
fn keep_surface(pixel: vec2<u32>, surface: vec4<u32>, packed: vec4<u32>, depths: vec4<f32>) {
    textureStore(mask_surfaces, pixel, surface);
    textureStore(mask_points, pixel, packed);
}
