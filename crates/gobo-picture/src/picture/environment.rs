//! The environment as a texture.
use gobo::{
    Error,
    gpu::{Allocator, write_records},
    model::{Environment, Scene},
};
use half::f16;
use std::sync::Arc;
use wgpu::{Texture, TextureFormat, TextureUsages};

/// Texture of the environment; a single texel without one. The texture of `last` is reused while its
/// environment stays.
pub(super) fn environment_texture(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    scene: &Scene,
    last: &mut Option<(Arc<Environment>, Texture)>,
) -> Result<Texture, Error> {
    const NAME: &str = "environment";
    let (format, usage) = (TextureFormat::Rgba16Float, TextureUsages::COPY_DST);
    let Some(environment) = &scene.environment else {
        return allocator.records(NAME, format, 0, usage);
    };
    if let Some((known, texture)) = last
        && Arc::ptr_eq(known, environment)
    {
        let texels = u64::from(texture.width()) * u64::from(texture.height());
        allocator.memory.add(NAME, texels * size_of::<[f16; 4]>() as u64);
        return Ok(texture.clone());
    }
    let texels = environment.texels().iter();
    let halves: Vec<[f16; 4]> =
        texels.map(|texel| texel.extend(1.0).to_array().map(f16::from_f32)).collect();
    let texture = allocator.records(NAME, format, halves.len() as u64, usage)?;
    write_records(queue, &texture, bytemuck::cast_slice(&halves).to_vec());
    *last = Some((environment.clone(), texture.clone()));
    Ok(texture)
}
