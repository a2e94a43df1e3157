// Depths of opaque casters in a map.

import package::bind::sampled::opaques;
import package::bind::uniform::picture_params;
import package::records::view::GpuView;

// Opaque depth of a texel, per channel.
fn solid_depths(view: GpuView, at: vec2<u32>) -> vec3<f32> {
    let depths = textureLoad(opaques, at, view.layer, 0).rgb;
    return select(depths.rrr, depths, picture_params.colored != 0u);
}
