// Windows of a blur. CPU reference: crates/gobo-reference/src/blur.rs. Rust: src/stage/blur.rs.

import package::bind::sampled::opaques;
import package::bind::uniform::blur_params;
import package::records::view::GpuView;

struct BlurParams {
    radius: i32,  // radius of the window [texels]
    scale: f32,   // factor of a squared offset in the exponent
    level: u32,   // mip level to make of the filter map, from the one before
    pad_0: u32,
}

// First and last offset of the texels that are on the map; `before`, `behind`: number of texels on either
// side.
fn window(before: i32, behind: i32) -> vec2<i32> {
    return vec2(max(-blur_params.radius, -before), min(blur_params.radius, behind));
}

fn gaussian(off: i32) -> f32 {
    return exp(f32(off * off) * blur_params.scale);
}

// Whether no opaque surface of the texel is in front of `near`, the first translucent depth of the window.
fn sees(view: GpuView, at: vec2<i32>, near: f32) -> bool {
    return textureLoad(opaques, at, view.layer, 0).r >= near;
}
