//! What is done to the whole picture behind its bands: occlusion of ambient light, and bloom.
use crate::{
    error::Error,
    frame::{Commands, Dispatch, Kernels},
    gpu::{Allocator, KernelDesc, Resources},
    model::{Occlusion, Scene},
    records::bloom_sizes,
    stage::{bloom, features::Features, occlusion},
};
use glam::UVec2;
use wgpu::{
    Texture, TextureFormat,
    TextureFormat::{Rg32Uint, Rgba16Float, Rgba32Float, Rgba32Uint},
    TextureUsages,
};

/// Passes over the whole picture, in order.
#[derive(Debug)]
pub(super) struct Finish {
    /// Ambient light by pixel, if it is occluded.
    ambients: Option<Texture>,
    /// Linear light behind the last pass.
    pub radiance: Texture,
    pub commands: Commands,
}

/// What passes are made of.
pub(super) struct ToFinish<'a, 'b> {
    pub allocator: &'a mut Allocator<'b>,
    pub kernels: &'a Kernels,
    /// View, parameters and pixels.
    pub resources: &'a Resources<'a>,
}

impl ToFinish<'_, '_> {
    fn texture(
        &mut self,
        name: &'static str,
        format: TextureFormat,
        size: UVec2,
    ) -> Result<Texture, Error> {
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let extent = [u64::from(size.x), u64::from(size.y), 1];
        self.allocator.texture(name, format, extent, usage)
    }

    /// One invocation per texel of `size`.
    fn run(
        &self,
        desc: &KernelDesc,
        size: UVec2,
        own: &[(&'static str, &Texture)],
    ) -> Result<Dispatch, Error> {
        let all = self.resources.clone();
        let resources = own.iter().fold(all, |all, &(name, texture)| all.with(name, texture));
        let groups = size.to_array().map(|texels| texels.div_ceil(bloom::GROUP_SIZE));
        let work = [groups[0], groups[1], 1];
        Ok(self.kernels.dispatch(desc, Features::NONE, &resources, work)?)
    }
}

impl Finish {
    /// `composited`: light of the bands.
    pub(super) fn new(
        mut to: ToFinish<'_, '_>,
        scene: &Scene,
        composited: &Texture,
    ) -> Result<Self, Error> {
        let mut own =
            Self { ambients: None, radiance: composited.clone(), commands: Commands::new() };
        let size = scene.camera.size;
        if scene.occlusion != Occlusion::None {
            own.occlude(&mut to, size)?;
        }
        if scene.bloom > 0.0 {
            own.spread(&mut to, size)?;
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

    fn occlude(&mut self, to: &mut ToFinish<'_, '_>, size: UVec2) -> Result<(), Error> {
        let half = (size + 1) / 2;
        let ambients = to.texture("ambients", Rgba32Uint, size)?;
        let occlusions = to.texture("occlusions", Rg32Uint, half)?;
        let radiance = to.texture("radiance", Rgba32Float, size)?;
        let own = [
            ("ambients", &ambients),
            ("occlusions", &occlusions),
            ("composited", &self.radiance),
            ("radiance", &radiance),
        ];
        let search = to.run(&occlusion::SEARCH, half, &own)?;
        let apply = to.run(&occlusion::APPLY, size, &own)?;
        self.commands.pass("gobo occlusion", [search, apply]);
        (self.ambients, self.radiance) = (Some(ambients), radiance);
        Ok(())
    }

    fn spread(&mut self, to: &mut ToFinish<'_, '_>, size: UVec2) -> Result<(), Error> {
        let mut passes = Vec::new();
        let (mut finer, mut levels) = (self.radiance.clone(), Vec::new());
        for size in bloom_sizes(size) {
            let level = to.texture("bloom", Rgba16Float, size)?;
            let own = [("bloom_from", &finer), ("bloom_to", &level)];
            passes.push(to.run(&bloom::DOWN, size, &own)?);
            levels.push((size, level.clone()));
            finer = level;
        }
        let mut spread = finer;
        for (size, level) in levels.iter().rev().skip(1) {
            let next = to.texture("bloom", Rgba16Float, *size)?;
            let own = [("bloom_from", &spread), ("bloom_level", level), ("bloom_to", &next)];
            passes.push(to.run(&bloom::UP, *size, &own)?);
            spread = next;
        }
        let radiance = to.texture("radiance", Rgba32Float, size)?;
        let own =
            [("bloom_from", &spread), ("composited", &self.radiance), ("radiance", &radiance)];
        passes.push(to.run(&bloom::APPLY, size, &own)?);
        self.commands.pass("gobo bloom", passes);
        self.radiance = radiance;
        Ok(())
    }
}
