//! Softening of dithered maps: holes become a grey filter, after all batches.
use super::{
    context::{map_groups, view_uniform},
    kernels::{Kernels, OnDemand, Variant},
    maps::Maps,
    plan::Plan,
};
use crate::{
    error::Error,
    gpu::{Allocator, Resources, Timeline},
    stage::{
        features::Features,
        filter::{CURVE_RUN_LAYERS, CURVE_TEXELS, FilterParams, GROUP_SIZE},
    },
};
use wgpu::{BindGroup, TextureFormat::Rgba32Float, TextureUsages};

/// Both passes, bound for each batch of views.
#[derive(Debug)]
pub(super) struct Soften {
    /// Maps before softening.
    pub raw: Maps,
    pub window: u32,
    rows: wgpu::Texture,
    /// Rows of curves, if there are any.
    curve_rows: Option<wgpu::Texture>,
    /// Features that the curve kernels are specialised to.
    features: Features,
    params: wgpu::Buffer,
    passes: Vec<Pass>,
}

#[derive(Debug)]
struct Pass {
    rows: BindGroup,
    columns: BindGroup,
    curves: Option<[BindGroup; 2]>,
    groups: [u32; 3],
}

impl Soften {
    /// Makes the passes, and the maps that they fill from `raw`; `window` as in
    /// [`crate::model::dither::window`].
    pub(super) fn new(
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
        let (features, passes) = (Features::NONE, Vec::new());
        Ok((soft, Self { raw, window, rows, curve_rows, features, params, passes }))
    }

    /// Kernels of the row and the column pass.
    fn kernels<'a>(&self, kernels: &'a Kernels) -> [&'a OnDemand; 2] {
        if self.raw.colored.is_some() {
            [&kernels.colored_rows, &kernels.colored_columns]
        } else {
            [&kernels.filter_rows, &kernels.filter_columns]
        }
    }

    /// Binds the passes for the views of `plans`. `over`: hits may add light.
    pub(super) fn bind(
        &mut self,
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &mut Kernels,
        plans: &[Plan],
        soft: &Maps,
        over: bool,
    ) -> Result<(), Error> {
        let device = allocator.device;
        let Maps { nodes, gain, .. } = *soft;
        self.features = Features { nodes, gain, over, ..Features::NONE };
        if self.curve_rows.is_some() {
            kernels.plan(device, Variant::CurveColumns, self.features)?;
        }
        let kernels = &*kernels;
        let [rows_kernel, columns_kernel] = self.kernels(kernels);
        let resources = self
            .raw
            .resources()
            .with("rows", &self.rows)
            .with("filter_params", &self.params)
            .with("soft_filters", &soft.filters)
            .with("soft_nearests", &soft.nearests)
            .with("soft_opaques", &soft.opaques);
        let pass = |plan: &Plan| {
            let views = view_uniform(allocator, queue, &plan.views);
            let resources = resources.clone().with("views", &views);
            Ok(Pass {
                rows: rows_kernel.bind(device, &resources)?,
                columns: columns_kernel.bind(device, &resources)?,
                curves: self.bind_curves(device, kernels, &resources, soft)?,
                groups: map_groups(&plan.views, GROUP_SIZE),
            })
        };
        self.passes = plans.iter().map(pass).collect::<Result<_, Error>>()?;
        Ok(())
    }

    /// Binds the row and the column pass of a map with curves.
    fn bind_curves(
        &self,
        device: &wgpu::Device,
        kernels: &Kernels,
        resources: &Resources<'_>,
        soft: &Maps,
    ) -> Result<Option<[BindGroup; 2]>, Error> {
        let Some(rows) = &self.curve_rows else { return Ok(None) };
        let resources = resources
            .clone()
            .with("rows", rows)
            .with("colored", self.raw.colored.as_ref().unwrap_or(&self.raw.opaques))
            .with("raw_curves", &self.raw.curves)
            .with("curves", &soft.curves);
        let columns = kernels.get(Variant::CurveColumns, self.features);
        let rows = kernels.curve_rows.bind(device, &resources)?;
        Ok(Some([rows, columns.bind(device, &resources)?]))
    }

    pub(super) fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let [rows_kernel, columns_kernel] = self.kernels(kernels);
        for Pass { rows, columns, curves, groups } in &self.passes {
            let mut pass = timeline.pass(encoder, "gobo filter");
            rows_kernel.record(&mut pass, rows, *groups);
            columns_kernel.record(&mut pass, columns, *groups);
            if let Some([rows, columns]) = curves {
                kernels.curve_rows.record(&mut pass, rows, *groups);
                let groups = [groups[0], groups[1].div_ceil(CURVE_TEXELS), groups[2]];
                kernels
                    .get(Variant::CurveColumns, self.features)
                    .record(&mut pass, columns, groups);
            }
        }
    }
}
