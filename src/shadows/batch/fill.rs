//! What maps hold without casters, copied from a buffer of a few rows: as many bytes as the maps have are not uploaded.
use crate::{
    frame::Commands, gpu::Allocator, model::TILE_SIZE, records::GpuView, shadows::views::maps::Maps,
};
use half::f16;
use wgpu::{
    Buffer, BufferUsages, COPY_BYTES_PER_ROW_ALIGNMENT, Extent3d, Origin3d, TexelCopyBufferInfo,
    TexelCopyBufferLayout, TexelCopyTextureInfo, Texture,
};

const LABEL: &str = "gobo clear";
/// Most bytes that are the source of a copy: they stay in a core's cache.
pub(super) const SOURCE_BYTES: u64 = 1 << 18;

/// Sets the opaque depths of `views` to 1.
pub(super) fn fill_depths(
    commands: &mut Commands,
    allocator: &mut Allocator<'_>,
    views: &[GpuView],
    maps: &Maps,
) {
    let far = source(allocator, "far", 1.0_f32);
    fill(commands, &far, views, &maps.opaques);
    maps.colored.iter().for_each(|colored| fill(commands, &far, views, colored));
}

/// Sets the filters and nearest depths of `views` to 1.
pub(super) fn fill_filters(
    commands: &mut Commands,
    allocator: &mut Allocator<'_>,
    views: &[GpuView],
    maps: &Maps,
) {
    let far = source(allocator, "far", 1.0_f32);
    fill(commands, &far, views, &maps.nearests);
    let clear = source(allocator, "clear_light", f16::ONE);
    fill(commands, &clear, views, &maps.filters);
}

/// A buffer of one value again and again.
fn source<T: bytemuck::NoUninit>(
    allocator: &mut Allocator<'_>,
    name: &'static str,
    value: T,
) -> Buffer {
    let values = vec![value; SOURCE_BYTES as usize / size_of::<T>()];
    allocator.filled(name, &values, BufferUsages::COPY_SRC)
}

/// Copies the bytes of `source` to all texels of the tiles of `views`.
fn fill(commands: &mut Commands, source: &Buffer, views: &[GpuView], texture: &Texture) {
    let texel = texture.format().block_copy_size(None).expect("a colour format");
    for view in views {
        let width = view.tiles_x * TILE_SIZE;
        let height = (view.size.y as u32).next_multiple_of(TILE_SIZE);
        let row = (width * texel).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT);
        let most = (SOURCE_BYTES as u32 / row).max(1);
        let layout =
            TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
        for first in (0..height).step_by(most as usize) {
            let origin = Origin3d { x: view.origin.x, y: view.origin.y + first, z: view.layer };
            let to = TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
            let size =
                Extent3d { width, height: most.min(height - first), depth_or_array_layers: 1 };
            let from = TexelCopyBufferInfo { buffer: source, layout };
            commands.copy_buffer_to_texture(LABEL, &from, to, size);
        }
    }
}
