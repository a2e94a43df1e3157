//! Softening of dithered maps, after all batches: holes become a filter.
use super::{passes, texture_like};
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::Allocator,
    shadows::{batch::batch_plan::BatchPlan, views::maps::Maps},
    stage::soften::{self, SoftenParams},
};
use wgpu::{Buffer, TextureFormat::Rgba32Float};

/// Maps before softening, and intermediate textures.
#[derive(Debug)]
pub(in crate::shadows) struct Soften {
    /// Maps before softening.
    pub raw: Maps,
    pub window: u32,
    rows: wgpu::Texture,
    params: Buffer,
}

impl Soften {
    /// Allocates the maps that are filled from `raw`; `window` as in
    /// [`crate::model::dither::window`].
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        raw: Maps,
        window: u32,
    ) -> Result<(Maps, Self), Error> {
        let soft = raw.softened(allocator)?;
        let layers = soften::run_layers(raw.colored.is_some(), raw.nodes);
        let rows = texture_like(allocator, "soften_rows", Rgba32Float, &raw.filters, layers)?;
        let value = SoftenParams { radius: (window / 2) as i32, ..SoftenParams::default() };
        let params = allocator.uniform("soften_params", &value);
        Ok((soft, Self { raw, window, rows, params }))
    }

    /// The softening for the views of `batches`, each with the buffer of its views.
    pub(in crate::shadows) fn commands(
        &self,
        kernels: &Kernels,
        batches: &[(&BatchPlan, &Buffer)],
        soft: &Maps,
    ) -> Result<Commands, Error> {
        let Self { raw, rows, params, .. } = self;
        let features = soft.features();
        let [of_rows, of_columns] = match &raw.colored {
            Some(_) => [&soften::COLORED_ROWS, &soften::COLORED_COLUMNS],
            None => [&soften::ROWS, &soften::COLUMNS],
        };
        let resources = raw
            .resources()
            .with("rows", rows)
            .with("soften_params", params)
            .with("colored", raw.colored.as_ref().unwrap_or(&raw.opaques))
            .with("raw_curves", &raw.curves)
            .with("curves", &soft.curves)
            .with("soft_filters", &soft.filters)
            .with("soft_nearests", &soft.nearests)
            .with("soft_opaques", &soft.opaques);
        passes("gobo soften", batches, &resources, |resources, [x, y, z]| {
            let run = |desc| kernels.dispatch(desc, features, resources, [x, y, z]);
            let mut dispatches = vec![run(of_rows)?, run(of_columns)?];
            if raw.nodes > 0 {
                dispatches.push(run(&soften::CURVE_COLUMNS)?);
            }
            Ok(dispatches)
        })
    }
}
