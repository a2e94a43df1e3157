// Texels that count in a blur. CPU reference: src/reference/blur.rs.

import package::bind::sampled::opaques;
import package::records::view::GpuView;

// Whether no opaque surface of the texel is in front of `near`, the first translucent depth of the window.
fn sees(view: GpuView, at: vec2<i32>, near: f32) -> bool {
    return textureLoad(opaques, at, view.layer, 0).r >= near;
}
