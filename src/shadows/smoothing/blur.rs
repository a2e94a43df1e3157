//! Blur of the filter maps and curves, in place, after all batches. Only rendered maps are blurred: kept maps
//! are blurred already.
use super::{passes, texture_like};
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, Resources},
    model::BLUR_DEVIATIONS,
    shadows::{batch::batch_plan::BatchPlan, views::maps::Maps},
    stage::blur::{self, BlurParams},
};
use wgpu::{
    Buffer, Texture,
    TextureFormat::{Rgba32Float, Rgba32Uint},
};

/// Textures of the blur.
#[derive(Debug)]
pub(in crate::shadows) struct Blur {
    /// Radius of the window \[texels\].
    pub radius: u32,
    rows: Texture,
    near_around: Texture,
    /// `None` without curves.
    row_curves: Option<Texture>,
    params: Buffer,
}

impl Blur {
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        maps: &Maps,
        radius: u32,
    ) -> Result<Self, Error> {
        let filters = &maps.filters;
        let rows = texture_like(allocator, "blur_rows", Rgba32Float, filters, 1)?;
        let near_around = texture_like(allocator, "near_around", Rgba32Float, filters, 1)?;
        let mut curves = || texture_like(allocator, "row_curves", Rgba32Uint, &maps.curves, 1);
        let row_curves = (maps.nodes > 0).then(&mut curves).transpose()?;
        let scale = -0.5 * (BLUR_DEVIATIONS / radius as f32).powi(2);
        let value = BlurParams { radius: radius as i32, scale, ..BlurParams::default() };
        let params = allocator.uniform("blur_params", &value);
        Ok(Self { radius, rows, near_around, row_curves, params })
    }

    /// The blur for the views of `batches`, each with the buffer of its views.
    pub(in crate::shadows) fn commands(
        &self,
        kernels: &Kernels,
        batches: &[(&BatchPlan, &Buffer)],
        maps: &Maps,
    ) -> Result<Commands, Error> {
        let features = maps.features();
        // `near_rows` and `rows` share a texture: `near_columns` reads the former before `rows` is written.
        let resources = maps
            .resources()
            .with("near_rows", &self.rows)
            .with("near_around", &self.near_around)
            .with("rows", &self.rows)
            .with("blur_params", &self.params);
        passes("gobo blur", batches, &resources, |resources, groups| {
            let run =
                |desc, resources: &Resources| kernels.dispatch(desc, features, resources, groups);
            let mut dispatches = vec![
                run(&blur::NEAR_ROWS, resources)?,
                run(&blur::NEAR_COLUMNS, resources)?,
                run(&blur::ROWS, resources)?,
            ];
            if let Some(row_curves) = &self.row_curves {
                let of = |from, to| resources.clone().with("raw_curves", from).with("curves", to);
                dispatches.push(run(&blur::CURVE_ROWS, &of(&maps.curves, row_curves))?);
                dispatches.push(run(&blur::CURVE_COLUMNS, &of(row_curves, &maps.curves))?);
            }
            dispatches.push(run(&blur::COLUMNS, resources)?);
            Ok(dispatches)
        })
    }
}
