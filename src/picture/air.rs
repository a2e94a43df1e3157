//! The air of a picture, bound and ready to be recorded after the maps it is lit through.
use crate::{
    error::Error,
    gpu::{Allocator, Timeline, array_view},
    reference::air::columns,
    scene::Scene,
    shadows::kernels::{Kernels, Variant},
    stage::{
        air::{AirParams, GROUP_SIZE},
        hits::Features,
    },
};
use wgpu::{BindGroup, BindingResource, TextureFormat::Rgba32Float, TextureUsages};

#[derive(Debug)]
pub(super) struct PreparedAir {
    scatter: BindGroup,
    sum: BindGroup,
    /// Of columns, and slices.
    groups: [u32; 3],
    features: Features,
}

impl PreparedAir {
    /// The volume, and what fills it where the scene has any air. `uniforms`: views and params;
    /// `shadows`: lights and maps.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &mut Kernels,
        features: Features,
        scene: &Scene,
        uniforms: [&BindingResource<'_>; 2],
        shadows: &[BindingResource<'_>; 6],
    ) -> Result<(wgpu::Texture, Option<Self>), Error> {
        let usage = TextureUsages::STORAGE_BINDING;
        let Some(air) = &scene.air else {
            return Ok((allocator.texture("air", Rgba32Float, [1, 1, 1], usage)?, None));
        };
        let size = columns(scene.camera.size);
        let extent = [u64::from(size.x), u64::from(size.y), u64::from(air.steps)];
        let sources = allocator.texture("air_sources", Rgba32Float, extent, usage)?;
        let volume = allocator.texture("air", Rgba32Float, extent, usage)?;
        let params = allocator.uniform::<AirParams>("air_params");
        queue.write_buffer(&params, 0, bytemuck::bytes_of(&AirParams::new(air)));
        let params = params.as_entire_binding();
        let texture = BindingResource::TextureView;
        let (source_view, volume_view) = (array_view(&sources), array_view(&volume));
        let device = allocator.device;
        let mut scatter: Vec<_> = uniforms.into_iter().cloned().collect();
        scatter.push(params.clone());
        scatter.extend_from_slice(shadows);
        scatter.push(texture(&source_view));
        let sum = [uniforms[0].clone(), params, texture(&source_view), texture(&volume_view)];
        let groups = [size.x.div_ceil(GROUP_SIZE), size.y.div_ceil(GROUP_SIZE), air.steps];
        let scatter = kernels.make(device, Variant::AirScatter, features).bind(device, &scatter);
        let sum = kernels.air_sum.bind(device, &sum);
        Ok((volume, Some(Self { scatter, sum, groups, features })))
    }

    pub(super) fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let mut pass = timeline.pass(encoder, "air");
        kernels.get(Variant::AirScatter, self.features).record(
            &mut pass,
            &self.scatter,
            self.groups,
        );
        let [x, y, _] = self.groups;
        kernels.air_sum.record(&mut pass, &self.sum, [x, y, 1]);
    }
}
