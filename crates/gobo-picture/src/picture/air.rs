//! Air of a picture: the volume that its other kernels read, lit band by band, up to the surfaces.
use super::bands::TileRect;
use crate::stage::air::{AIR_BLOCK, AIR_RUN, ITEM_HEAD, REACH, SUM, SUM_SIZE, scatter};
use gobo::{
    Error,
    frame::{Commands, Dispatch, Kernels, Work},
    gpu::{Allocator, Resources},
    model::Scene,
    stage::features::Features,
};
use gobo_reference::records::{AirParams, air_columns};
use wgpu::{Buffer, BufferUsages, Texture, TextureFormat::Rgba32Float, TextureUsages};

/// Air of a picture, as a volume.
#[derive(Debug)]
pub(super) struct Air {
    features: Features,
    /// Views, parameters, lights and maps, and the air's own textures and buffers.
    resources: Resources,
    /// Lit slices of each column; in the upper 16 bits, those of all bands but the last that needed more.
    pub ends: Buffer,
    items: Buffer,
}

/// Resources for other kernels, and the volume, `None` without air. `resources`: views, parameters, lights
/// and maps; `bands`: of the picture.
pub(super) fn air(
    allocator: &mut Allocator<'_>,
    features: Features,
    scene: &Scene,
    resources: &Resources,
    bands: &[TileRect],
) -> Result<(Texture, Option<Air>), Error> {
    let usage = TextureUsages::STORAGE_BINDING;
    let Some(air) = &scene.air else {
        return Ok((allocator.texture("air", Rgba32Float, [1, 1, 1], usage)?, None));
    };
    let size = air_columns(scene.camera.size);
    let extent = [u64::from(size.x), u64::from(size.y), u64::from(air.steps)];
    let sources = allocator.texture("air_sources", Rgba32Float, extent, usage)?;
    let volume = allocator.texture("air", Rgba32Float, extent, usage)?;
    let columns = u64::from(size.element_product());
    let ends = allocator.storage::<u32>("air_ends", columns, BufferUsages::COPY_SRC)?;
    let blocks = bands.iter().map(|rect| blocks(rect).into_iter().map(u64::from).product());
    let most = blocks.max().unwrap_or(0) * u64::from(air.steps.div_ceil(AIR_RUN));
    let words = u64::from(ITEM_HEAD) + most;
    let items = allocator.storage::<u32>("air_items", words, BufferUsages::INDIRECT)?;
    let params = AirParams::new(air, scene.mean_ambient(), scene.samples);
    let params = allocator.uniform("air_params", &params);
    let resources = resources
        .clone()
        .with("air_params", &params)
        .with("sources", &sources)
        .with("air", &volume)
        .with("air_ends", &ends)
        .with("air_items", &items);
    Ok((volume, Some(Air { features, resources, ends, items })))
}

/// Columns and rows of blocks that a band sees: those of its tiles, and one around them.
fn blocks(rect: &TileRect) -> [u32; 2] {
    (rect.size + 2).to_array()
}

impl Air {
    /// Clears the volume, before the bands of a picture.
    pub(super) fn clear(&self) -> Commands {
        let mut commands = Commands::new();
        commands.clear("gobo air", &self.ends);
        commands.clear("gobo air", &self.items);
        commands
    }

    /// Lights the air that the pixels of a band need and no earlier band did, behind the band's visible
    /// surfaces. `band`: the band's uniform.
    pub(super) fn of_band(
        &self,
        kernels: &Kernels,
        rect: &TileRect,
        band: &Buffer,
    ) -> Result<Vec<Dispatch>, Error> {
        let resources = self.resources.clone().with("band", band);
        let [x, y] = blocks(rect);
        let run = |desc, work: Work| kernels.dispatch(desc, self.features, &resources, work);
        let sums = [x, y].map(|blocks| (blocks * AIR_BLOCK).div_ceil(SUM_SIZE));
        Ok(vec![
            run(&REACH, [x, y, 1].into())?,
            run(scatter(self.features), Work::indirect(&self.items, 0))?,
            run(&SUM, [sums[0], sums[1], 1].into())?,
        ])
    }
}
