// Windows of a blur. CPU reference: src/reference/blur.rs. Rust: src/stage/blur.rs.

import package::bind::uniform::blur_params;

struct BlurParams {
    radius: i32,  // radius of the window [texels]
    scale: f32,   // factor of a squared offset in the exponent
    level: u32,   // mip level of the filter map that is made, from the one before
    pad_0: u32,
}

// Offsets of the window around `at` that are on a map of `size` texels.
fn window_ends(at: i32, size: i32) -> vec2<i32> {
    return vec2(max(-blur_params.radius, -at), min(blur_params.radius, size - 1 - at));
}

fn gaussian(off: i32) -> f32 {
    return exp(f32(off * off) * blur_params.scale);
}
