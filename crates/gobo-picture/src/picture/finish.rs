//! Passes over the whole picture after its bands: refraction, occlusion of ambient light, and bloom.
use crate::stage::{bloom, occlusion, refraction, shade::composite};
use glam::UVec2;
use gobo::{
    Error,
    frame::{Commands, Dispatch, Kernels},
    gpu::{Allocator, KernelDesc, Resource, Resources, level_view, view},
    model::{Material, Occlusion, Scene},
    records::image_level_size,
    stage::features::Features,
};
use gobo_reference::records::{bloom_sizes, refraction_levels};
use wgpu::{
    Texture, TextureFormat,
    TextureFormat::{Rg32Uint, Rgba16Float, Rgba32Float, Rgba32Uint},
    TextureUsages, TextureView,
    TextureViewDimension::D2,
};

/// Passes over the whole picture, in order.
#[derive(Debug)]
pub(super) struct Finish {
    /// Ambient light by pixel, if it is occluded.
    ambients: Option<Texture>,
    /// Opaque surfaces, and places where pixels see them through glass, if any glass refracts.
    behind: Option<(TextureView, Texture)>,
    /// Linear light after the last pass.
    pub radiance: Texture,
    pub commands: Commands,
}

/// Inputs of the passes.
pub(super) struct ToFinish<'a, 'b> {
    pub allocator: &'a mut Allocator<'b>,
    pub kernels: &'a Kernels,
    /// View, parameters and pixels.
    pub resources: &'a Resources,
}

impl ToFinish<'_, '_> {
    fn texture(
        &mut self,
        name: &'static str,
        format: TextureFormat,
        size: UVec2,
    ) -> Result<Texture, Error> {
        self.texture_with_levels(name, format, size, 1)
    }

    fn texture_with_levels(
        &mut self,
        name: &'static str,
        format: TextureFormat,
        size: UVec2,
        levels: u32,
    ) -> Result<Texture, Error> {
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let extent = [u64::from(size.x), u64::from(size.y), 1];
        self.allocator.texture_with_levels(name, format, extent, levels, usage)
    }

    /// One invocation per texel of `size`.
    fn run<R: Clone + Into<Resource>>(
        &self,
        desc: &KernelDesc,
        size: UVec2,
        textures: &[(&'static str, R)],
    ) -> Result<Dispatch, Error> {
        let all = self.resources.clone();
        let resources =
            textures.iter().fold(all, |all, (name, texture)| all.with(name, texture.clone()));
        let groups = size.to_array().map(|texels| texels.div_ceil(bloom::GROUP_SIZE));
        let work = [groups[0], groups[1], 1];
        Ok(self.kernels.dispatch(desc, Features::NONE, &resources, work)?)
    }
}

impl Finish {
    /// `composited`: light of the bands, or their costs, which no pass changes.
    pub(super) fn new(
        mut to: ToFinish<'_, '_>,
        scene: &Scene,
        is_cost: bool,
        composited: &Texture,
    ) -> Result<Self, Error> {
        let (radiance, commands) = (composited.clone(), Commands::new());
        let mut finish = Self { ambients: None, behind: None, radiance, commands };
        if is_cost {
            return Ok(finish);
        }
        let size = scene.camera.size;
        if scene.materials.iter().any(Material::refracts) {
            finish.refract(&mut to, size)?;
        }
        if scene.occlusion != Occlusion::None {
            finish.occlude(&mut to, size)?;
        }
        if scene.bloom > 0.0 {
            finish.spread(&mut to, size)?;
        }
        Ok(finish)
    }

    /// The kernel that composites the bands, and keeps ambient light and light behind glass apart for the
    /// passes.
    pub(super) fn composite(&self) -> &'static KernelDesc {
        composite(self.ambients.is_some(), self.behind.is_some())
    }

    /// `resources`, and the textures that the bands write for the passes.
    pub(super) fn with(&self, resources: Resources) -> Resources {
        resources
            .with_any("ambients", self.ambients.as_ref())
            .with_any("behinds", self.behind.as_ref().map(|(behinds, _)| behinds))
            .with_any("bends", self.behind.as_ref().map(|(_, bends)| bends))
    }

    fn refract(&mut self, to: &mut ToFinish<'_, '_>, size: UVec2) -> Result<(), Error> {
        let count = refraction_levels(size);
        let behinds = to.texture_with_levels("behinds", Rgba16Float, size, count)?;
        let bends = to.texture("bends", Rgba32Uint, size)?;
        let radiance = to.texture("radiance", Rgba32Float, size)?;
        let levels: Vec<TextureView> =
            (0..count).map(|level| level_view(&behinds, level, D2)).collect();
        let mut passes = Vec::new();
        for (level, pair) in (1..).zip(levels.windows(2)) {
            let textures = [("bloom_from", &pair[0]), ("bloom_to", &pair[1])];
            passes.push(to.run(&bloom::DOWN, image_level_size(size, level), &textures)?);
        }
        let whole = view(&behinds);
        let textures: [(_, Resource); 4] = [
            ("behinds", (&whole).into()),
            ("bends", (&bends).into()),
            ("composited", (&self.radiance).into()),
            ("radiance", (&radiance).into()),
        ];
        passes.push(to.run(&refraction::APPLY, size, &textures)?);
        self.commands.pass("gobo refraction", passes);
        (self.behind, self.radiance) = (Some((levels[0].clone(), bends)), radiance);
        Ok(())
    }

    fn occlude(&mut self, to: &mut ToFinish<'_, '_>, size: UVec2) -> Result<(), Error> {
        let half = (size + 1) / 2;
        let ambients = to.texture("ambients", Rgba32Uint, size)?;
        let occlusions = to.texture("occlusions", Rg32Uint, half)?;
        let radiance = to.texture("radiance", Rgba32Float, size)?;
        let textures = [
            ("ambients", &ambients),
            ("occlusions", &occlusions),
            ("composited", &self.radiance),
            ("radiance", &radiance),
        ];
        let search = to.run(&occlusion::SEARCH, half, &textures)?;
        let apply = to.run(&occlusion::APPLY, size, &textures)?;
        self.commands.pass("gobo occlusion", [search, apply]);
        (self.ambients, self.radiance) = (Some(ambients), radiance);
        Ok(())
    }

    fn spread(&mut self, to: &mut ToFinish<'_, '_>, size: UVec2) -> Result<(), Error> {
        let mut passes = Vec::new();
        let (mut finer, mut levels) = (self.radiance.clone(), Vec::new());
        for size in bloom_sizes(size) {
            let level = to.texture("bloom", Rgba16Float, size)?;
            let textures = [("bloom_from", &finer), ("bloom_to", &level)];
            passes.push(to.run(&bloom::DOWN, size, &textures)?);
            levels.push((size, level.clone()));
            finer = level;
        }
        let mut spread = finer;
        for (size, level) in levels.iter().rev().skip(1) {
            let next = to.texture("bloom", Rgba16Float, *size)?;
            let textures = [("bloom_from", &spread), ("bloom_level", level), ("bloom_to", &next)];
            passes.push(to.run(&bloom::UP, *size, &textures)?);
            spread = next;
        }
        let radiance = to.texture("radiance", Rgba32Float, size)?;
        let textures =
            [("bloom_from", &spread), ("composited", &self.radiance), ("radiance", &radiance)];
        passes.push(to.run(&bloom::APPLY, size, &textures)?);
        self.commands.pass("gobo bloom", passes);
        self.radiance = radiance;
        Ok(())
    }
}
