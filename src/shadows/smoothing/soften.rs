//! Softening of dithered maps: holes become a grey filter, after all batches.
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
    stage::{
        colored,
        features::{Features, Flags},
        filter::{self, CURVE_RUN_LAYERS, CURVE_TEXELS, FilterParams, GROUP_SIZE},
    },
};
use wgpu::{TextureFormat::Rgba32Float, TextureUsages};

/// Maps before softening, and intermediate textures.
#[derive(Debug)]
pub(in crate::shadows) struct Soften {
    /// Maps before softening.
    pub raw: Maps,
    pub window: u32,
    rows: wgpu::Texture,
    /// Rows of curves, if there are any.
    curve_rows: Option<wgpu::Texture>,
    params: wgpu::Buffer,
}

impl Soften {
    /// Allocates the maps that are filled from `raw`; `window` as in
    /// [`crate::model::dither::window`].
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        raw: Maps,
        window: u32,
    ) -> Result<(Maps, Self), Error> {
        let soft = raw.softened(allocator)?;
        let like = raw.filters.size();
        let size = [like.width, like.height, like.depth_or_array_layers].map(u64::from);
        // Each view has two layers with coloured dithering.
        let layers = if raw.colored.is_some() { 2 } else { 1 };
        let mut rows = |name, layers| {
            let size = [size[0], size[1], size[2] * u64::from(layers)];
            allocator.texture(name, Rgba32Float, size, TextureUsages::STORAGE_BINDING)
        };
        let curve_rows =
            (raw.nodes > 0).then(|| rows("curve_rows", CURVE_RUN_LAYERS)).transpose()?;
        let rows = rows("filter_rows", layers)?;
        let params = allocator.uniform::<FilterParams>("filter_params");
        let value = FilterParams {
            radius: (window / 2) as i32,
            colored: u32::from(raw.colored.is_some()),
            pad_0: 0,
            pad_1: 0,
        };
        queue.write_buffer(&params, 0, bytemuck::bytes_of(&value));
        Ok((soft, Self { raw, window, rows, curve_rows, params }))
    }

    /// The softening of the views of `plans`. `over`: hits may add light.
    pub(in crate::shadows) fn commands(
        &self,
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        plans: &[Plan],
        soft: &Maps,
        over: bool,
    ) -> Result<Commands, Error> {
        let Self { raw, rows, params, .. } = self;
        let features = Features::of_maps(soft.nodes, soft.gain).with(Flags::HAS_OVER, over);
        let [of_rows, of_columns] = match &raw.colored {
            Some(_) => [&colored::ROWS, &colored::COLUMNS],
            None => [&filter::ROWS, &filter::COLUMNS],
        };
        let resources = raw
            .resources()
            .with("rows", rows)
            .with("filter_params", params)
            .with("soft_filters", &soft.filters)
            .with("soft_nearests", &soft.nearests)
            .with("soft_opaques", &soft.opaques);
        let mut commands = Commands::new();
        for plan in plans {
            let views = view_uniform(allocator, queue, &plan.views);
            let resources = resources.clone().with("views", &views);
            let [x, y, z] = map_groups(&plan.views, GROUP_SIZE);
            let run = |desc, resources: &Resources<'_>, y| {
                kernels.dispatch(desc, features, resources, [x, y, z])
            };
            let mut dispatches =
                vec![run(of_rows, &resources, y)?, run(of_columns, &resources, y)?];
            if let Some(rows) = &self.curve_rows {
                let resources = resources
                    .with("rows", rows)
                    .with("colored", raw.colored.as_ref().unwrap_or(&raw.opaques))
                    .with("raw_curves", &raw.curves)
                    .with("curves", &soft.curves);
                dispatches.push(run(&filter::CURVE_ROWS, &resources, y)?);
                let y = y.div_ceil(CURVE_TEXELS);
                dispatches.push(run(&filter::CURVE_COLUMNS, &resources, y)?);
            }
            commands.pass("gobo filter", dispatches);
        }
        Ok(commands)
    }
}
