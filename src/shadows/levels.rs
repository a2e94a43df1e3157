//! Levels of the maps of area lights, bound and ready to be recorded after the maps.
use super::kernels::Variant;
use crate::{
    error::Error,
    gpu::{Allocator, Kernel, Resources},
    records::{BLOCK_TEXELS, LightRecords, MAX_AREAS, ROW, SKIRT, level_size},
    stage::{
        features::Features,
        levels::{GROUP_SIZE, LevelParams},
    },
};
use glam::UVec2;
use wgpu::{
    BindGroup, Extent3d, Origin3d, TexelCopyTextureInfo, Texture, TextureFormat::Rgba32Uint,
    TextureUsages,
};

/// Levels of all maps of area lights.
#[derive(Debug)]
pub(crate) struct AreaLevels {
    /// Texture that look-ups read as `levels`.
    pub texture: Texture,
    /// Target of one level at a time.
    made: Texture,
    passes: Vec<LevelPass>,
}

#[derive(Debug)]
struct LevelPass {
    kernel: Kernel,
    bindings: BindGroup,
    groups: [u32; 3],
    /// First row of `levels`, and number of rows.
    rows: [u32; 2],
}

impl AreaLevels {
    /// `None` without area lights. `resources`: the maps, `lights` and `picture_params`; `features`: of the
    /// maps; `kernel` compiles one.
    pub(crate) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        records: &LightRecords,
        resources: &Resources<'_>,
        features: Features,
        mut kernel: impl FnMut(Variant, Features) -> Result<Kernel, Error>,
    ) -> Result<Option<Self>, Error> {
        if records.areas.is_empty() {
            return Ok(None);
        }
        if records.areas.len() > MAX_AREAS {
            let (have, need) = (MAX_AREAS as u64, records.areas.len() as u64);
            let remedy = "remove the source of some lights";
            return Err(Error::Limit { limit: "lights that have a source", have, need, remedy });
        }
        let device = allocator.device;
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
        let mut passes = Vec::new();
        for (level, (&first, &end)) in (1..).zip(firsts.iter().zip(ends)) {
            let params = allocator.uniform::<LevelParams>("level_params");
            let values = LevelParams { level, first_block: first, pad_0: 0, pad_1: 0 };
            queue.write_buffer(&params, 0, bytemuck::bytes_of(&values));
            let variant = if level == 1 { Variant::FirstLevel } else { Variant::NextLevel };
            let kernel = kernel(variant, features)?;
            let own = resources
                .clone()
                .with("levels", &texture)
                .with("new_levels", &made)
                .with("level_params", &params);
            let blocks = level_size(largest, level) + 2 * SKIRT;
            let groups = blocks.map(|edge| edge.div_ceil(GROUP_SIZE));
            let row = |block: u32| block / (ROW / BLOCK_TEXELS);
            passes.push(LevelPass {
                bindings: kernel.bind(device, &own)?,
                kernel,
                groups: [groups.x, groups.y, views],
                rows: [row(first), row(end - first)],
            });
        }
        Ok(Some(Self { texture, made, passes }))
    }

    /// Records the passes of all levels.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        for LevelPass { kernel, bindings, groups, rows } in &self.passes {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some("gobo levels"),
                timestamp_writes: None,
            });
            kernel.record(&mut pass, bindings, *groups);
            drop(pass);
            let place = TexelCopyTextureInfo {
                origin: Origin3d { x: 0, y: rows[0], z: 0 },
                ..self.texture.as_image_copy()
            };
            let size = Extent3d { width: ROW, height: rows[1], depth_or_array_layers: 1 };
            encoder.copy_texture_to_texture(self.made.as_image_copy(), place, size);
        }
    }
}
