//! The shadow atlas: every view's filter, nearest depth and opaque depth.
use crate::{
    error::Error,
    gpu::Allocator,
    view::{TILE_SIZE, View},
};
use glam::UVec2;
use wgpu::{
    TextureFormat::{R32Float, Rgba16Float},
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
    /// Of each view.
    pub places: Vec<MapPlace>,
}

impl Maps {
    pub(super) fn new(allocator: &mut Allocator<'_>, views: &[View]) -> Result<Self, Error> {
        // Whole tiles, so that no workgroup writes into a neighbour's map.
        let largest = views
            .iter()
            .fold(UVec2::splat(TILE_SIZE), |size, view| size.max(view.tiles() * TILE_SIZE));
        let size = [largest.x, largest.y, views.len().max(1) as u32].map(u64::from);
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let places =
            (0..views.len() as u32).map(|layer| MapPlace { origin: UVec2::ZERO, layer }).collect();
        Ok(Self {
            filters: allocator.texture("filters", Rgba16Float, size, usage)?,
            nearests: allocator.texture("nearests", R32Float, size, usage)?,
            opaques: allocator.texture("opaques", R32Float, size, usage)?,
            places,
        })
    }
}
