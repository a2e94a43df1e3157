//! Maps with holes to maps with a grey filter, after all batches.
use super::{context::view_uniform, kernels::Kernels, maps::Maps, plan::Plan};
use crate::{
    error::Error,
    gpu::{Allocator, Kernel, Timeline},
    stage::filter::{FilterParams, GROUP_SIZE},
};
use glam::Vec2;
use wgpu::{BindGroup, TextureFormat::Rgba32Float, TextureUsages};

/// Both passes, bound for each batch of views.
#[derive(Debug)]
pub(super) struct Soften {
    /// What the maps are before.
    pub raw: Maps,
    pub window: u32,
    rows: wgpu::Texture,
    params: wgpu::Buffer,
    passes: Vec<Pass>,
}

#[derive(Debug)]
struct Pass {
    rows: BindGroup,
    columns: BindGroup,
    groups: [u32; 3],
}

impl Soften {
    /// And the maps that it fills from `raw`; `window` as in [`crate::model::dither::window`].
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        raw: Maps,
        window: u32,
    ) -> Result<(Maps, Self), Error> {
        let soft = raw.softened(allocator)?;
        let like = raw.filters.size();
        let size = [like.width, like.height, like.depth_or_array_layers].map(u64::from);
        // Of each view two layers where there are channels.
        let layers = size[2] * if raw.colored.is_some() { 2 } else { 1 };
        let size = [size[0], size[1], layers];
        let rows =
            allocator.texture("filter_rows", Rgba32Float, size, TextureUsages::STORAGE_BINDING)?;
        let params = allocator.uniform::<FilterParams>("filter_params");
        let value = FilterParams { radius: (window / 2) as i32, pad_0: 0, pad_1: 0, pad_2: 0 };
        queue.write_buffer(&params, 0, bytemuck::bytes_of(&value));
        Ok((soft, Self { raw, window, rows, params, passes: Vec::new() }))
    }

    /// Rows and columns.
    fn kernels<'a>(&self, kernels: &'a Kernels) -> [&'a Kernel; 2] {
        if self.raw.colored.is_some() {
            [&kernels.colored_rows, &kernels.colored_columns]
        } else {
            [&kernels.filter_rows, &kernels.filter_columns]
        }
    }

    /// To the views of `plans`.
    pub(super) fn bind(
        &mut self,
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        plans: &[Plan],
        soft: &Maps,
    ) -> Result<(), Error> {
        let device = allocator.device;
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
            let largest = plan.views.iter().fold(Vec2::ZERO, |size, view| size.max(view.size));
            let groups = largest.as_uvec2().map(|edge| edge.div_ceil(GROUP_SIZE));
            Ok(Pass {
                rows: rows_kernel.bind(device, &resources)?,
                columns: columns_kernel.bind(device, &resources)?,
                groups: [groups.x, groups.y, plan.views.len() as u32],
            })
        };
        self.passes = plans.iter().map(pass).collect::<Result<_, Error>>()?;
        Ok(())
    }

    pub(super) fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let [rows_kernel, columns_kernel] = self.kernels(kernels);
        for Pass { rows, columns, groups } in &self.passes {
            let mut pass = timeline.pass(encoder, "filter");
            rows_kernel.record(&mut pass, rows, *groups);
            columns_kernel.record(&mut pass, columns, *groups);
        }
    }
}
