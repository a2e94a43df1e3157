// Light that surfaces scatter to their far side. CPU reference: crates/gobo-reference/src/shade/seen.rs.

import package::bind::uniform::materials;
import package::features::{HAS_FAR_SIDES, HAS_TEXTURES};
import package::hit::triangle::triangle_image;
import package::records::material::{GpuMaterial, NO_TEXTURE, far_side_of};

struct FarSide {
    is_there: bool,
    color: vec3<f32>, // share of the light from the far side that is scattered
    near: f32,        // share of the light on this side that stays
}

fn far_side(material: GpuMaterial, setup: u32, pixel: vec2<f32>, barycentric: vec3<f32>) -> FarSide {
    let index = far_side_of(material);
    if !HAS_FAR_SIDES || index == 0u {
        return FarSide(false, vec3(0.0), 1.0);
    }
    let far = materials[index - 1u];
    var color = far.tint.rgb;
    if HAS_TEXTURES && far.texture != NO_TEXTURE {
        color *= triangle_image(far.texture, far.texture_size, setup, pixel, barycentric, false).rgba.rgb;
    }
    return FarSide(true, color, 1.0 - far.transmission);
}
