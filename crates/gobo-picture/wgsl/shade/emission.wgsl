// Emission of a triangle. CPU reference: crates/gobo-reference/src/shade/mod.rs.

import package::features::HAS_TEXTURES;
import package::hit::triangle::triangle_image;
import package::records::material::{GpuMaterial, NO_TEXTURE};

fn emission_at(material: GpuMaterial, setup: u32, pixel: vec2<f32>, barycentric: vec3<f32>) -> vec3<f32> {
    if HAS_TEXTURES && material.emissive_texture != NO_TEXTURE {
        let layer = material.emissive_texture;
        let size = material.emissive_size;
        return material.emission * triangle_image(layer, size, setup, pixel, barycentric, true).rgba.rgb;
    }
    return material.emission;
}
