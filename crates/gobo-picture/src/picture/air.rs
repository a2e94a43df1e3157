//! Air of a picture: the volume that its other kernels read.
use crate::stage::air::{GROUP_SIZE, SUM, scatter};
use gobo::{
    Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, Resources},
    model::Scene,
    records::{AirParams, air_columns},
    stage::features::Features,
};
use wgpu::{Texture, TextureFormat::Rgba32Float, TextureUsages};

/// The volume, and the commands that fill it after the maps, none without air. `resources`: views,
/// parameters, lights and maps.
pub(super) fn air(
    allocator: &mut Allocator<'_>,
    kernels: &Kernels,
    features: Features,
    scene: &Scene,
    resources: &Resources,
) -> Result<(Texture, Commands), Error> {
    let mut commands = Commands::new();
    let usage = TextureUsages::STORAGE_BINDING;
    let Some(air) = &scene.air else {
        return Ok((allocator.texture("air", Rgba32Float, [1, 1, 1], usage)?, commands));
    };
    let size = air_columns(scene.camera.size);
    let extent = [u64::from(size.x), u64::from(size.y), u64::from(air.steps)];
    let sources = allocator.texture("air_sources", Rgba32Float, extent, usage)?;
    let volume = allocator.texture("air", Rgba32Float, extent, usage)?;
    let params = allocator.uniform("air_params", &AirParams::new(air, scene.mean_ambient()));
    let resources = resources
        .clone()
        .with("air_params", &params)
        .with("sources", &sources)
        .with("air", &volume);
    let [x, y] = [size.x, size.y].map(|columns| columns.div_ceil(GROUP_SIZE));
    let scattered = kernels.dispatch(scatter(features), features, &resources, [x, y, air.steps])?;
    let summed = kernels.dispatch(&SUM, features, &resources, [x, y, 1])?;
    commands.pass("gobo air", [scattered, summed]);
    Ok((volume, commands))
}
