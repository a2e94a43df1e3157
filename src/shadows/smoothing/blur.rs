//! Blur of the filter maps and curves, in place, after all batches. Only rendered maps are blurred: maps
//! that are kept already are.
use crate::shadows::{
    batch::{
        context::{map_groups, view_uniform},
        plan::Plan,
    },
    views::maps::Maps,
};
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, Resources},
    model::BLUR_DEVIATIONS,
    stage::{
        blur::{self, BlurParams, GROUP_SIZE},
        features::Features,
    },
};
use wgpu::{
    Texture,
    TextureFormat::{Rgba32Float, Rgba32Uint},
    TextureUsages,
};

/// Textures of the blur.
#[derive(Debug)]
pub(in crate::shadows) struct Blur {
    /// Radius of the window [texels].
    pub radius: u32,
    rows: Texture,
    near_around: Texture,
    /// `None` without curves.
    row_curves: Option<Texture>,
    params: wgpu::Buffer,
}

impl Blur {
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        maps: &Maps,
        radius: u32,
    ) -> Result<Self, Error> {
        let mut like = |name, texture: &Texture, format| {
            let size = texture.size();
            let size = [size.width, size.height, size.depth_or_array_layers].map(u64::from);
            allocator.texture(name, format, size, TextureUsages::STORAGE_BINDING)
        };
        let rows = like("blur_rows", &maps.filters, Rgba32Float)?;
        let near_around = like("near_around", &maps.filters, Rgba32Float)?;
        let row_curves =
            (maps.nodes > 0).then(|| like("row_curves", &maps.curves, Rgba32Uint)).transpose()?;
        let params = allocator.uniform::<BlurParams>("blur_params");
        let scale = -0.5 * (BLUR_DEVIATIONS / radius as f32).powi(2);
        let value = BlurParams { radius: radius as i32, scale, ..BlurParams::default() };
        queue.write_buffer(&params, 0, bytemuck::bytes_of(&value));
        Ok(Self { radius, rows, near_around, row_curves, params })
    }

    /// The blur of the views of `plans`.
    pub(in crate::shadows) fn commands(
        &self,
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        plans: &[Plan],
        maps: &Maps,
    ) -> Result<Commands, Error> {
        let features = Features::of_maps(maps.nodes, maps.gain);
        // `near_rows` and `rows` share a texture: `near_columns` reads the former before `rows` is written.
        let resources = maps
            .resources()
            .with("near_rows", &self.rows)
            .with("near_around", &self.near_around)
            .with("rows", &self.rows)
            .with("blur_params", &self.params);
        let mut commands = Commands::new();
        for plan in plans {
            let views = view_uniform(allocator, queue, &plan.views);
            let resources = resources.clone().with("views", &views);
            let groups = map_groups(&plan.views, GROUP_SIZE);
            let run = |desc, resources: &Resources<'_>| {
                kernels.dispatch(desc, features, resources, groups)
            };
            let mut dispatches = vec![
                run(&blur::NEAR_ROWS, &resources)?,
                run(&blur::NEAR_COLUMNS, &resources)?,
                run(&blur::ROWS, &resources)?,
            ];
            if let Some(row_curves) = &self.row_curves {
                let resources = resources.clone().with("row_curves", row_curves);
                dispatches.push(run(&blur::CURVE_ROWS, &resources)?);
                dispatches.push(run(&blur::CURVE_COLUMNS, &resources)?);
            }
            dispatches.push(run(&blur::COLUMNS, &resources)?);
            commands.pass("gobo blur", dispatches);
        }
        Ok(commands)
    }
}
