//! What is done to the whole picture behind its bands: occlusion of ambient light.
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, Resources},
    model::Scene,
    stage::{
        features::Features,
        occlusion::{APPLY, GROUP_SIZE, OcclusionParams, SEARCH},
    },
};
use glam::UVec2;
use wgpu::{
    Texture,
    TextureFormat::{Rg32Uint, Rgba32Float, Rgba32Uint},
    TextureUsages,
};

/// Passes over the whole picture, in order.
#[derive(Debug)]
pub(super) struct Finish {
    /// Ambient light by pixel, if it is occluded.
    ambients: Option<Texture>,
    /// What the last pass writes: linear light.
    pub radiance: Texture,
    pub commands: Commands,
}

impl Finish {
    /// `composited`: light of the bands; `resources`: view, parameters and pixels.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        scene: &Scene,
        composited: &Texture,
        resources: &Resources<'_>,
    ) -> Result<Self, Error> {
        let mut own =
            Self { ambients: None, radiance: composited.clone(), commands: Commands::new() };
        if let Some(params) = OcclusionParams::new(scene.occlusion, scene.camera.fov_y) {
            own.occlude(allocator, queue, kernels, &params, resources)?;
        }
        Ok(own)
    }

    /// Whether the bands keep the ambient light apart.
    pub(super) fn keeps_ambient(&self) -> bool {
        self.ambients.is_some()
    }

    /// `resources` and those that the bands write for the passes.
    pub(super) fn with<'a>(&'a self, resources: Resources<'a>) -> Resources<'a> {
        self.ambients.iter().fold(resources, |all, it| all.with("ambients", it))
    }

    fn occlude(
        &mut self,
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        params: &OcclusionParams,
        resources: &Resources<'_>,
    ) -> Result<(), Error> {
        let size = UVec2::new(self.radiance.width(), self.radiance.height());
        let half = (size + 1) / 2;
        let extent = |size: UVec2| [u64::from(size.x), u64::from(size.y), 1];
        let storage = TextureUsages::STORAGE_BINDING;
        let ambients = allocator.texture("ambients", Rgba32Uint, extent(size), storage)?;
        let occlusions = allocator.texture("occlusions", Rg32Uint, extent(half), storage)?;
        let usage = storage | TextureUsages::COPY_SRC;
        let radiance = allocator.texture("radiance", Rgba32Float, extent(size), usage)?;
        let uniform = allocator.uniform::<OcclusionParams>("occlusion_params");
        queue.write_buffer(&uniform, 0, bytemuck::bytes_of(params));
        let resources = resources
            .clone()
            .with("occlusion_params", &uniform)
            .with("ambients", &ambients)
            .with("occlusions", &occlusions)
            .with("composited", &self.radiance)
            .with("radiance", &radiance);
        let groups = |size: UVec2| [size.x.div_ceil(GROUP_SIZE), size.y.div_ceil(GROUP_SIZE), 1];
        let run = |desc, size| kernels.dispatch(desc, Features::NONE, &resources, groups(size));
        self.commands.pass("gobo occlusion", [run(&SEARCH, half)?, run(&APPLY, size)?]);
        (self.ambients, self.radiance) = (Some(ambients), radiance);
        Ok(())
    }
}
