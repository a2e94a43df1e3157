//! Levels of the maps of area lights, made after the maps.
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, KernelError, Resources},
    records::{BLOCK_TEXELS, GpuLight, LightRecords, MAX_AREAS, ROW, SKIRT, level_size},
    stage::{
        features::Features,
        levels::{self, GROUP_SIZE, LevelParams},
    },
};
use glam::UVec2;
use wgpu::{
    Extent3d, Origin3d, TexelCopyTextureInfo, Texture, TextureFormat::Rgba32Uint, TextureUsages,
};

/// Levels of all maps of area lights.
#[derive(Debug)]
pub(crate) struct AreaLevels {
    /// Texture that look-ups read as `levels`.
    pub texture: Texture,
    /// Makes all levels, after the maps.
    pub commands: Commands,
}

impl AreaLevels {
    /// Asks for the kernels, so that they are compiled with others. `features`: of the maps.
    pub(crate) fn request_kernels(
        kernels: &Kernels,
        features: Features,
    ) -> Result<(), KernelError> {
        let mut descs = [&levels::FIRST, &levels::NEXT].into_iter();
        descs.try_for_each(|desc| kernels.get(desc, features).map(drop))
    }

    /// `None` without area lights. `resources`: the maps, `lights` and `picture_params`; `features`: of the
    /// maps.
    pub(crate) fn new(
        allocator: &mut Allocator<'_>,
        kernels: &Kernels,
        records: &LightRecords,
        resources: &Resources,
        features: Features,
    ) -> Result<Option<Self>, Error> {
        if records.areas.is_empty() {
            return Ok(None);
        }
        let viewpoints: usize =
            records.lights.iter().filter(|it| it.area().is_some()).map(GpuLight::viewpoints).sum();
        let (have, need) = (MAX_AREAS as u64, viewpoints as u64);
        let remedy = "remove the source of some lights, or give them fewer viewpoints";
        Error::check_limit("viewpoints of sources", have, need, remedy)?;
        let ends = &records.level_ends;
        let firsts: Vec<u32> = std::iter::once(0).chain(ends.iter().copied()).collect();
        let texels = |blocks: u32| u64::from(blocks) * u64::from(BLOCK_TEXELS);
        let longest = firsts.iter().zip(ends).map(|(first, end)| end - first).max().unwrap_or(0);
        let all = texels(ends.last().copied().unwrap_or(0));
        let read = TextureUsages::COPY_DST | TextureUsages::STORAGE_BINDING;
        let texture = allocator.records("levels", Rgba32Uint, all, read)?;
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let made = allocator.records("new_levels", Rgba32Uint, texels(longest), usage)?;
        let sizes = (0..records.leveled.len()).map(|i| records.view_of(i).size.as_uvec2());
        let largest = sizes.fold(UVec2::ZERO, UVec2::max);
        let views = records.leveled.len() as u32;
        let mut commands = Commands::new();
        for (level, (&first, &end)) in (1..).zip(firsts.iter().zip(ends)) {
            const LABEL: &str = "gobo levels";
            let values = LevelParams { level, first_block: first, pad_0: 0, pad_1: 0 };
            let params = allocator.uniform("level_params", &values);
            let desc = if level == 1 { &levels::FIRST } else { &levels::NEXT };
            let resources = resources
                .clone()
                .with("levels", &texture)
                .with("new_levels", &made)
                .with("level_params", &params);
            let blocks = level_size(largest, level) + 2 * SKIRT;
            let groups = blocks.map(|edge| edge.div_ceil(GROUP_SIZE));
            let groups = [groups.x, groups.y, views];
            commands.pass(LABEL, [kernels.dispatch(desc, features, &resources, groups)?]);
            let row = |block: u32| block / (ROW / BLOCK_TEXELS);
            let place = TexelCopyTextureInfo {
                origin: Origin3d { x: 0, y: row(first), z: 0 },
                ..texture.as_image_copy()
            };
            let size = Extent3d { width: ROW, height: row(end - first), depth_or_array_layers: 1 };
            commands.copy_texture(LABEL, made.as_image_copy(), place, size);
        }
        Ok(Some(Self { texture, commands }))
    }
}
