//! The shadow atlas: every view's filter, nearest depth and opaque depth.
use crate::{
    error::Error,
    gpu::Allocator,
    view::{TILE_SIZE, View},
};
use glam::UVec2;
use wgpu::{
    TextureFormat::{R32Float, Rgba16Float, Rgba32Float},
    TextureUsages,
};

/// Where a view's map is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapPlace {
    /// First texel.
    pub origin: UVec2,
    pub layer: u32,
}

/// Texture arrays that hold all views' maps.
#[derive(Debug)]
pub struct Maps {
    /// `F`, rgba16float.
    pub filters: wgpu::Texture,
    /// `D`, r32float.
    pub nearests: wgpu::Texture,
    /// `Z`, r32float.
    pub opaques: wgpu::Texture,
    /// `Z` by channel, rgba32float, where dithering is coloured; `opaques` is the last of them.
    pub colored: Option<wgpu::Texture>,
    /// Of each view.
    pub places: Vec<MapPlace>,
}

impl Maps {
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        views: &[View],
        colored: bool,
    ) -> Result<Self, Error> {
        // Whole tiles, so that no workgroup writes into a neighbour's map.
        let largest = views
            .iter()
            .fold(UVec2::splat(TILE_SIZE), |size, view| size.max(view.tiles() * TILE_SIZE));
        let size = [largest.x, largest.y, views.len().max(1) as u32].map(u64::from);
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let places =
            (0..views.len() as u32).map(|layer| MapPlace { origin: UVec2::ZERO, layer }).collect();
        let opaques =
            allocator.texture("opaques", R32Float, size, usage | TextureUsages::COPY_DST)?;
        fill(queue, &opaques, 1.0);
        let usage_of_colored = usage | TextureUsages::COPY_DST;
        let colored = colored
            .then(|| allocator.texture("colored", Rgba32Float, size, usage_of_colored))
            .transpose()?;
        if let Some(colored) = &colored {
            fill(queue, colored, [1.0_f32; 4]);
        }
        Ok(Self {
            filters: allocator.texture("filters", Rgba16Float, size, usage)?,
            nearests: allocator.texture("nearests", R32Float, size, usage)?,
            opaques,
            colored,
            places,
        })
    }
}

impl Maps {
    /// Of the same size and places, with nothing in them.
    pub(super) fn softened(&self, allocator: &mut Allocator<'_>) -> Result<Self, Error> {
        let like = self.filters.size();
        let size = [like.width, like.height, like.depth_or_array_layers].map(u64::from);
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        Ok(Self {
            filters: allocator.texture("soft_filters", Rgba16Float, size, usage)?,
            nearests: allocator.texture("soft_nearests", R32Float, size, usage)?,
            opaques: allocator.texture("soft_opaques", R32Float, size, usage)?,
            colored: None,
            places: self.places.clone(),
        })
    }
}

/// Every texel of an array.
fn fill<T: bytemuck::NoUninit>(queue: &wgpu::Queue, texture: &wgpu::Texture, value: T) {
    let size = texture.size();
    let layer = vec![value; (size.width * size.height) as usize];
    for z in 0..size.depth_or_array_layers {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: 0, z },
                ..texture.as_image_copy()
            },
            bytemuck::cast_slice(&layer),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(size.width * size_of::<T>() as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d { depth_or_array_layers: 1, ..size },
        );
    }
}
