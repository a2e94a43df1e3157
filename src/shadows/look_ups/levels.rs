//! Levels of the maps of area lights, made after the maps.
use super::{
    level_store::{LevelKey, Levels},
    light_shelf::LightShelf,
};
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, KernelError, Resources, Timeline},
    records::{BLOCK_TEXELS, GpuLight, LightRecords, MAX_AREAS, ROLE_FACE, ROW, SKIRT, level_size},
    shadows::Maps,
    stage::{
        features::{Features, Flags},
        levels::{self, GROUP_SIZE, LevelParams},
    },
};
use glam::UVec2;
use std::sync::Arc;
use wgpu::{Extent3d, Origin3d, TexelCopyTextureInfo, Texture};

/// Levels of all maps of area lights.
#[derive(Debug)]
pub struct AreaLevels {
    levels: Arc<Levels>,
    /// Makes all levels, after the maps.
    commands: Commands,
    map_count: u64,
    shelf: Arc<LightShelf>,
}

/// Features of the kernels; `has_faces`: whether some of the views are faces of cubes.
fn features(maps: &Maps, has_faces: bool) -> Features {
    maps.features().with(Flags::HAS_FACES, has_faces)
}

impl AreaLevels {
    /// Requests the kernels, so that they are compiled with others. `has_faces`: whether some views are faces
    /// of cubes.
    pub(crate) fn request_kernels(
        kernels: &Kernels,
        maps: &Maps,
        has_faces: bool,
    ) -> Result<(), KernelError> {
        for desc in [&levels::FIRST, &levels::NEXT] {
            kernels.get(desc, features(maps, false))?;
            if has_faces {
                kernels.get(desc, features(maps, true))?;
            }
        }
        Ok(())
    }

    /// `None` without area lights. `shelf`: the maps'; `resources`: the maps, `lights` and `picture_params`.
    pub fn new(
        allocator: &mut Allocator<'_>,
        kernels: &Kernels,
        maps: &Maps,
        shelf: &Arc<LightShelf>,
        records: &LightRecords,
        resources: &Resources,
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
        let all = ends.last().copied().unwrap_or(0);
        let views: Vec<_> = (0..records.leveled.len()).map(|i| *records.view_of(i)).collect();
        let has_faces = views.iter().any(|view| view.role == ROLE_FACE);
        let largest = views.iter().map(|view| view.size.as_uvec2()).fold(UVec2::ZERO, UVec2::max);
        let view_count = views.len() as u32;
        let key = LevelKey {
            leveled: records.leveled.clone(),
            views,
            maps: [maps.filters.clone(), maps.curves.clone()],
            gain: maps.gain,
        };
        let shelf = Arc::clone(shelf);
        let levels = shelf.levels.take(key, allocator, [all, longest].map(texels))?;
        let (texture, new) = (&levels.texture, &levels.new);
        let features = features(maps, has_faces);
        let mut commands = Commands::new();
        for (level, (&first, &end)) in (1..).zip(firsts.iter().zip(ends)) {
            const LABEL: &str = "gobo levels";
            let values = LevelParams { level, first_block: first, pad_0: 0, pad_1: 0 };
            let params = allocator.uniform("level_params", &values);
            let desc = if level == 1 { &levels::FIRST } else { &levels::NEXT };
            let resources = resources
                .clone()
                .with("levels", texture)
                .with("new_levels", new)
                .with("level_params", &params);
            let blocks = level_size(largest, level) + 2 * SKIRT;
            let groups = blocks.map(|edge| edge.div_ceil(GROUP_SIZE));
            let groups = [groups.x, groups.y, view_count];
            commands.pass(LABEL, [kernels.dispatch(desc, features, &resources, groups)?]);
            let row = |block: u32| block / (ROW / BLOCK_TEXELS);
            let place = TexelCopyTextureInfo {
                origin: Origin3d { x: 0, y: row(first), z: 0 },
                ..texture.as_image_copy()
            };
            let size = Extent3d { width: ROW, height: row(end - first), depth_or_array_layers: 1 };
            commands.copy_texture(LABEL, new.as_image_copy(), place, size);
        }
        Ok(Some(Self { levels, commands, map_count: view_count.into(), shelf }))
    }

    /// Texture that look-ups read as `levels`.
    pub fn texture(&self) -> &Texture {
        &self.levels.texture
    }

    /// Compiles the kernels, on this thread.
    pub(crate) fn compile(&self) -> Result<(), KernelError> {
        self.commands.compile()
    }

    /// Records the kernels that make the levels, after the maps; nothing if they were made since the maps
    /// were last drawn.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        if self.shelf.levels.must_make(&self.levels, self.map_count) {
            self.commands.record(encoder, timeline);
        }
    }
}
