//! Intermediate data of the pixels of a band of tiles.
use super::bands::pixels_of;
use crate::stage::{
    light_points::{LIST_COUNT, LIST_HEAD, POINT_TEXELS},
    shade::{CARRIED, LAYER_TEXELS, LAYERED_HEAD, PIXEL_POINTS},
};
use gobo::{
    Error,
    gpu::{Allocator, Memory, Resources, reused},
};
use std::sync::Arc;
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureUsages};

/// Intermediate data of the pixels of a band.
#[derive(Debug)]
pub(super) struct BandMemory {
    pub resources: Resources,
    /// Lists of the points to light, with the workgroup counts of their dispatches.
    pub point_lists: Buffer,
    /// Tiles with translucent casters, with the workgroup counts of a dispatch over them.
    pub layered_tiles: Buffer,
    /// Capacity of a band \[tiles\].
    pub tiles: u32,
    /// Points of one pixel.
    pub points_of_pixel: u32,
    /// Whether data is carried from round to round.
    carries: bool,
    has_layers: bool,
    /// Bytes by buffer and texture.
    pub memory: Memory,
}

impl BandMemory {
    /// `layers`, `panes`: whether pixels have translucent layers, and points for panes.
    fn new(
        device: &wgpu::Device,
        rounds: u32,
        tiles: u32,
        layers: bool,
        panes: bool,
    ) -> Result<Self, Error> {
        let mut memory = Memory::default();
        let allocator = &mut Allocator::new(device, &mut memory);
        let storage = TextureUsages::STORAGE_BINDING;
        let uint = TextureFormat::Rgba32Uint;
        let pixels = u64::from(pixels_of(tiles));
        let points_of_pixel = if panes { PIXEL_POINTS } else { 1 };
        let points = pixels * u64::from(points_of_pixel);
        let carries = rounds > 1;
        let carried = if carries { pixels * u64::from(CARRIED) } else { 1 };
        let layer_texels = if layers { pixels * u64::from(LAYER_TEXELS) } else { 1 };
        let mut records = |name, texels| allocator.records(name, uint, texels, storage);
        let seen = records("seen", pixels)?;
        let layers_of_pixels = records("layers", layer_texels)?;
        let points_of_band = records("points", points * u64::from(POINT_TEXELS))?;
        let lit = allocator.records("lit", TextureFormat::Rgba32Float, points, storage)?;
        let mut list = |name, words| allocator.storage::<u32>(name, words, BufferUsages::INDIRECT);
        let point_lists = list("point_lists", u64::from(LIST_COUNT * LIST_HEAD) + points)?;
        let layered_tiles = list("layered_tiles", u64::from(LAYERED_HEAD + tiles))?;
        let carried = allocator.storage::<[u32; 4]>("carried", carried, BufferUsages::empty())?;
        let resources = Resources::new()
            .with("seen_pixels", &seen)
            .with("layers", &layers_of_pixels)
            .with("points", &points_of_band)
            .with("lit", &lit)
            .with("point_lists", &point_lists)
            .with("layered_tiles", &layered_tiles)
            .with("carried", &carried);
        Ok(Self {
            resources,
            point_lists,
            layered_tiles,
            tiles,
            points_of_pixel,
            carries,
            has_layers: layers,
            memory,
        })
    }

    /// `former`, or new memory if that is shared or too small.
    pub(super) fn take(
        former: &mut Option<Arc<Self>>,
        device: &wgpu::Device,
        rounds: u32,
        tiles: u32,
        layers: bool,
        panes: bool,
    ) -> Result<Arc<Self>, Error> {
        let points = if panes { PIXEL_POINTS } else { 1 };
        let suffices = |former: &Self| {
            former.tiles == tiles
                && former.points_of_pixel == points
                && former.carries >= (rounds > 1)
                && former.has_layers >= layers
        };
        reused(former, suffices, || Self::new(device, rounds, tiles, layers, panes))
    }
}
