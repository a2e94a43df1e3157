//! Upload of casters, materials and images in kernel form.
use crate::{
    error::Error,
    gpu::Allocator,
    model::{Material, Texture},
    records::{GpuMaterial, MAX_MATERIALS, ROW, image_level_count, image_levels},
};
use bytemuck::Zeroable as _;
use glam::{UVec2, Vec3};
use std::ops::Range;
use wgpu::{
    TextureFormat::{Rgba8UnormSrgb, Rgba32Uint},
    TextureUsages,
};

/// Uploads records; `reserved`: number of further records behind them.
pub(super) fn upload<T: bytemuck::Pod>(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    name: &'static str,
    records: &[T],
    reserved: u32,
) -> Result<wgpu::Texture, Error> {
    let count = (records.len() as u64 + u64::from(reserved)) * u64::from(texels::<T>());
    let texture = allocator.records(
        name,
        Rgba32Uint,
        count,
        TextureUsages::COPY_DST | TextureUsages::STORAGE_BINDING,
    )?;
    write_rows(queue, &texture, 0, bytemuck::cast_slice(records));
    Ok(texture)
}

/// Texels of a record.
const fn texels<T>() -> u32 {
    size_of::<T>() as u32 / 16
}

/// Size of a row of a record texture \[bytes\].
pub(super) const ROW_BYTES: usize = ROW as usize * 16;

/// Uploads the rows that contain the records of `parts`, which are sorted.
pub(super) fn upload_parts<T: bytemuck::Pod>(
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    records: &[T],
    parts: &[Range<u32>],
) {
    let texels = texels::<T>();
    let bytes: &[u8] = bytemuck::cast_slice(records);
    let write = |rows: Range<u32>| {
        let end = (rows.end as usize * ROW_BYTES).min(bytes.len());
        write_rows(queue, texture, rows.start, &bytes[rows.start as usize * ROW_BYTES..end]);
    };
    let mut pending = 0..0;
    for part in parts {
        let rows = part.start * texels / ROW..(part.end * texels).div_ceil(ROW);
        if rows.start <= pending.end && !pending.is_empty() {
            pending.end = pending.end.max(rows.end);
        } else {
            if !pending.is_empty() {
                write(pending);
            }
            pending = rows;
        }
    }
    if !pending.is_empty() {
        write(pending);
    }
}

/// Writes whole rows, then the remainder of the last one.
fn write_rows(queue: &wgpu::Queue, texture: &wgpu::Texture, first_row: u32, bytes: &[u8]) {
    let row = ROW_BYTES;
    let whole = bytes.len() / row * row;
    let write = |first_row: u32, bytes: &[u8]| {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: first_row, z: 0 },
                ..texture.as_image_copy()
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d {
                width: (bytes.len().min(row) / 16) as u32,
                height: bytes.len().div_ceil(row) as u32,
                depth_or_array_layers: 1,
            },
        );
    };
    // A write is staged in one buffer, whose size is limited: 32 MiB at a time.
    let stretch = 512 * row;
    for (i, part) in bytes[..whole].chunks(stretch).enumerate() {
        write(first_row + (i * 512) as u32, part);
    }
    if whole < bytes.len() {
        write(first_row + (whole / row) as u32, &bytes[whole..]);
    }
}

/// Most texels of the texture array that holds all images: 4 GiB.
const MAX_TEXELS: u64 = 1 << 30;

pub(super) fn upload_images(
    allocator: &mut Allocator<'_>,
    queue: &wgpu::Queue,
    textures: &[Texture],
    has_levels: bool,
) -> Result<wgpu::Texture, Error> {
    let width = textures.iter().map(|t| t.width).max().unwrap_or(1);
    let height = textures.iter().map(|t| t.height).max().unwrap_or(1);
    let size = [width, height, textures.len().max(1) as u32].map(u64::from);
    // A layer is as wide as the widest image, and as high as the highest.
    let need = size.iter().product();
    let remedy =
        "make the textures smaller, or alike in size: each takes the largest width and height";
    Error::check_limit("texels of all textures", MAX_TEXELS, need, remedy)?;
    let levels = if has_levels { image_level_count(UVec2::new(width, height)) } else { 1 };
    let usage = TextureUsages::COPY_DST;
    let images = allocator.texture_with_levels("images", Rgba8UnormSrgb, size, levels, usage)?;
    for (layer, texture) in textures.iter().enumerate() {
        upload_image(queue, &images, layer, texture);
    }
    Ok(images)
}

pub(super) fn upload_image(
    queue: &wgpu::Queue,
    images: &wgpu::Texture,
    layer: usize,
    texture: &Texture,
) {
    let write = |mip_level: u32, [width, height]: [u32; 2], rgba: &[u8]| {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                mip_level,
                origin: wgpu::Origin3d { x: 0, y: 0, z: layer as u32 },
                ..images.as_image_copy()
            },
            rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * 4),
                rows_per_image: None,
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    };
    write(0, [texture.width, texture.height], &texture.rgba);
    if images.mip_level_count() > 1 {
        for (number, level) in (1..).zip(image_levels(texture)) {
            write(number, level.size.to_array(), &level.rgba);
        }
    }
}

pub(in crate::shadows) fn material_records(
    materials: &[Material],
    textures: &[Texture],
    blue_first: u32,
    absorptions: &[Vec3],
) -> Vec<GpuMaterial> {
    let record =
        |(m, &absorption)| GpuMaterial { blue_first, absorption, ..GpuMaterial::new(m, textures) };
    let mut records: Vec<_> = materials.iter().zip(absorptions).map(record).collect();
    records.resize(MAX_MATERIALS, GpuMaterial::zeroed());
    records
}
