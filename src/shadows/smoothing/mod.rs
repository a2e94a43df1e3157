//! Smoothing after all batches: softening of dithered maps, blur, and smaller levels.
pub(super) mod blur;
pub(super) mod filter_mips;
pub(super) mod soften;

use super::batch::{batch_plan::BatchPlan, context::map_groups};
use crate::{
    error::Error,
    frame::{Commands, Dispatch},
    gpu::{Allocator, KernelError, Resources},
};
use wgpu::{Buffer, Texture, TextureFormat, TextureUsages};

/// Texels of a workgroup in x and y.
const GROUP_SIZE: u32 = 8;

/// A texture like a map, with `layers` per layer of the map.
fn texture_like(
    allocator: &mut Allocator<'_>,
    name: &'static str,
    format: TextureFormat,
    map: &Texture,
    layers: u32,
) -> Result<Texture, Error> {
    let size = map.size();
    let size = [size.width, size.height, size.depth_or_array_layers * layers].map(u64::from);
    allocator.texture(name, format, size, TextureUsages::STORAGE_BINDING)
}

/// A pass over the texels of each batch's views; `dispatches`: from resources and workgroups.
fn passes(
    label: &'static str,
    batches: &[(&BatchPlan, &Buffer)],
    resources: &Resources,
    dispatches: impl Fn(&Resources, [u32; 3]) -> Result<Vec<Dispatch>, KernelError>,
) -> Result<Commands, Error> {
    let mut commands = Commands::new();
    for &(plan, views) in batches {
        let resources = resources.clone().with("views", views);
        commands.pass(label, dispatches(&resources, map_groups(&plan.views, GROUP_SIZE))?);
    }
    Ok(commands)
}
