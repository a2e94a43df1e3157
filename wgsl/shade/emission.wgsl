// Emission of a triangle. CPU reference: src/reference/shade/mod.rs.

import package::bind::sampled::images;
import package::features::HAS_TEXTURES;
import package::hit::triangle::triangle_uv;
import package::hit::texture::sample_texture;
import package::records::material::{GpuMaterial, NO_TEXTURE};

fn emission_at(material: GpuMaterial, setup: u32, barycentric: vec3<f32>) -> vec3<f32> {
    if HAS_TEXTURES && material.emissive_texture != NO_TEXTURE {
        let uv = triangle_uv(setup, barycentric);
        let image = sample_texture(images, material.emissive_texture, material.emissive_size, uv);
        return material.emission * image.rgb;
    }
    return material.emission;
}
