//! Air of a picture, bound and ready to be recorded after the maps that light it.
use crate::{
    error::Error,
    frame::Kernels,
    gpu::{Allocator, Resources, Timeline},
    model::Scene,
    records::{AirParams, air_columns},
    shadows::kernels::Variant,
    stage::{
        air::{GROUP_SIZE, SUM},
        features::Features,
    },
};
use wgpu::{BindGroup, TextureFormat::Rgba32Float, TextureUsages};

#[derive(Debug)]
pub(super) struct PreparedAir {
    scatter: BindGroup,
    sum: BindGroup,
    /// Workgroup grid for columns, and for slices.
    groups: [u32; 3],
    features: Features,
}

impl PreparedAir {
    /// The volume, and the passes that fill it if the scene has air. `resources`: views, parameters, lights
    /// and maps.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        features: Features,
        scene: &Scene,
        resources: &Resources<'_>,
    ) -> Result<(wgpu::Texture, Option<Self>), Error> {
        let usage = TextureUsages::STORAGE_BINDING;
        let Some(air) = &scene.air else {
            return Ok((allocator.texture("air", Rgba32Float, [1, 1, 1], usage)?, None));
        };
        let size = air_columns(scene.camera.size);
        let extent = [u64::from(size.x), u64::from(size.y), u64::from(air.steps)];
        let sources = allocator.texture("air_sources", Rgba32Float, extent, usage)?;
        let volume = allocator.texture("air", Rgba32Float, extent, usage)?;
        let params = allocator.uniform::<AirParams>("air_params");
        queue.write_buffer(
            &params,
            0,
            bytemuck::bytes_of(&AirParams::new(air, scene.mean_ambient())),
        );
        let own = resources
            .clone()
            .with("air_params", &params)
            .with("sources", &sources)
            .with("air", &volume);
        let device = allocator.device;
        let groups = [size.x.div_ceil(GROUP_SIZE), size.y.div_ceil(GROUP_SIZE), air.steps];
        let scatter = kernels.of(Variant::AirScatter, features)?.bind(device, &own)?;
        let sum = kernels.get(&SUM, features)?.bind(device, &own)?;
        Ok((volume, Some(Self { scatter, sum, groups, features })))
    }

    pub(super) fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let mut pass = timeline.pass(encoder, "gobo air");
        kernels.known(Variant::AirScatter, self.features).record(
            &mut pass,
            &self.scatter,
            self.groups,
        );
        let [x, y, _] = self.groups;
        let sum = kernels.get(&SUM, self.features).expect("it is bound");
        sum.record(&mut pass, &self.sum, [x, y, 1]);
    }
}
