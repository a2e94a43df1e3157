// Surfaces of masks of half the picture's size: one pixel of each 2 x 2, alternately the nearest and the
// farthest, so that of two surfaces that meet there, four neighbours hold both.

import package::bind::stored::{half_surfaces, mask_points, mask_surfaces};
import package::records::mask::offset_bits;

// Depths closer than this are equal: neighbouring pixels on a floor differ by rounding alone.
const TIED: f32 = 1e-6;

// `packed`: a texel of `mask_points`; `depths`: of the 2 x 2 pixels that contain this one.
fn keep_surface(pixel: vec2<u32>, surface: vec4<u32>, packed: vec4<u32>, depths: vec4<f32>) {
    textureStore(mask_surfaces, pixel, surface);
    let half = pixel / 2u;
    let is_near = ((half.x + half.y) & 1u) == 0u;
    // A pixel without a surface does not count as the farthest.
    let ranks = select(select(depths, 1.0 - depths, is_near), vec4(-1.0), depths >= vec4(1.0));
    let best = max(max(ranks.x, ranks.y), max(ranks.z, ranks.w));
    let ties = ranks >= vec4(best - TIED);
    let chosen = select(select(select(3u, 2u, ties.z), 1u, ties.y), 0u, ties.x);
    let offset = pixel & vec2(1u);
    if chosen == offset.x + 2u * offset.y {
        let stored = vec4(surface.xy, surface.z | offset_bits(offset), surface.w);
        textureStore(half_surfaces, half, stored);
        textureStore(mask_points, half, packed);
    }
}
