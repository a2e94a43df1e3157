//! Blur of the filter maps and curves, in place, after all batches. Only rendered maps are blurred: maps
//! that are kept already are.
use super::{
    context::{map_groups, view_uniform},
    kernels::{Kernels, Variant},
    maps::Maps,
    plan::Plan,
};
use crate::{
    error::Error,
    gpu::{Allocator, Timeline},
    model::BLUR_DEVIATIONS,
    stage::{
        blur::{BlurParams, GROUP_SIZE},
        features::Features,
    },
};
use wgpu::{
    BindGroup, Texture,
    TextureFormat::{Rgba32Float, Rgba32Uint},
    TextureUsages,
};

/// Passes of the blur, bound for each batch of views.
#[derive(Debug)]
pub(super) struct Blur {
    /// Radius of the window [texels].
    pub radius: u32,
    rows: Texture,
    near_around: Texture,
    /// `None` without curves.
    row_curves: Option<Texture>,
    /// Traits that the kernels that read curves are specialised to.
    features: Features,
    params: wgpu::Buffer,
    passes: Vec<Pass>,
}

#[derive(Debug)]
struct Pass {
    near_rows: BindGroup,
    near_columns: BindGroup,
    rows: BindGroup,
    columns: BindGroup,
    curves: Option<[BindGroup; 2]>,
    groups: [u32; 3],
}

impl Blur {
    pub(super) fn new(
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
        let (features, passes) = (Features::NONE, Vec::new());
        Ok(Self { radius, rows, near_around, row_curves, features, params, passes })
    }

    /// Binds the passes to the views of `plans`.
    pub(super) fn bind(
        &mut self,
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &mut Kernels,
        plans: &[Plan],
        maps: &Maps,
    ) -> Result<(), Error> {
        let device = allocator.device;
        self.features = Features { nodes: maps.nodes, gain: maps.gain, ..Features::NONE };
        kernels.plan(device, Variant::BlurNearRows, self.features)?;
        if self.row_curves.is_some() {
            kernels.plan(device, Variant::BlurCurveRows, self.features)?;
            kernels.plan(device, Variant::BlurCurveColumns, self.features)?;
        }
        let kernels = &*kernels;
        // `near_rows` and `rows` share a texture: `near_columns` reads the former before `rows` is written.
        let resources = maps
            .resources()
            .with("near_rows", &self.rows)
            .with("near_around", &self.near_around)
            .with("rows", &self.rows)
            .with("blur_params", &self.params);
        let pass = |plan: &Plan| {
            let views = view_uniform(allocator, queue, &plan.views);
            let resources = resources.clone().with("views", &views);
            let variant = |variant| kernels.get(variant, self.features);
            let curves = |row_curves: &Texture| {
                let resources = resources.clone().with("row_curves", row_curves);
                let rows = variant(Variant::BlurCurveRows).bind(device, &resources)?;
                let columns = variant(Variant::BlurCurveColumns).bind(device, &resources)?;
                Ok::<_, Error>([rows, columns])
            };
            Ok(Pass {
                near_rows: variant(Variant::BlurNearRows).bind(device, &resources)?,
                near_columns: kernels.blur_near_columns.bind(device, &resources)?,
                rows: kernels.blur_rows.bind(device, &resources)?,
                columns: kernels.blur_columns.bind(device, &resources)?,
                curves: self.row_curves.as_ref().map(curves).transpose()?,
                groups: map_groups(&plan.views, GROUP_SIZE),
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
        let variant = |variant| kernels.get(variant, self.features);
        for Pass { near_rows, near_columns, rows, columns, curves, groups } in &self.passes {
            let mut pass = timeline.pass(encoder, "gobo blur");
            variant(Variant::BlurNearRows).record(&mut pass, near_rows, *groups);
            kernels.blur_near_columns.record(&mut pass, near_columns, *groups);
            kernels.blur_rows.record(&mut pass, rows, *groups);
            if let Some([rows, columns]) = curves {
                variant(Variant::BlurCurveRows).record(&mut pass, rows, *groups);
                variant(Variant::BlurCurveColumns).record(&mut pass, columns, *groups);
            }
            kernels.blur_columns.record(&mut pass, columns, *groups);
        }
    }
}
