// Which texels say something of light. CPU twin: src/reference/blur.rs.

import package::bind::sampled::opaques;
import package::records::view::GpuView;

// Not where something opaque lies before `near`, all that is translucent around.
fn sees(view: GpuView, at: vec2<i32>, near: f32) -> bool {
    return textureLoad(opaques, at, view.layer, 0).r >= near;
}
