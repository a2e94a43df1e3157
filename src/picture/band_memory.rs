//! Intermediate data of the pixels of a band of tiles.
use super::bands::pixels_of;
use crate::{
    error::Error,
    gpu::{Allocator, Memory, Resources, reused},
    stage::shade::{
        CARRIED, LAYER_TEXELS, LAYERED_HEAD, LIST_COUNT, LIST_HEAD, PIXEL_POINTS, POINT_TEXELS,
    },
};
use std::sync::Arc;
use wgpu::{Buffer, BufferUsages, Texture, TextureFormat, TextureUsages};

/// Intermediate data of the pixels of a band.
#[derive(Debug)]
pub(super) struct BandMemory {
    seen: Texture,
    layers: Texture,
    points: Texture,
    lit: Texture,
    point_lists: Buffer,
    layered_tiles: Buffer,
    carried: Buffer,
    /// Capacity of a band [tiles].
    pub tiles: u32,
    points_of_pixel: u32,
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
        Ok(Self {
            seen: allocator.records("seen", uint, pixels, storage)?,
            layers: allocator.records("layers", uint, layer_texels, storage)?,
            points: allocator.records("points", uint, points * u64::from(POINT_TEXELS), storage)?,
            lit: allocator.records("lit", TextureFormat::Rgba32Float, points, storage)?,
            point_lists: allocator.storage::<u32>(
                "point_lists",
                u64::from(LIST_COUNT * LIST_HEAD) + points,
                BufferUsages::INDIRECT,
            )?,
            layered_tiles: allocator.storage::<u32>(
                "layered_tiles",
                u64::from(LAYERED_HEAD + tiles),
                BufferUsages::INDIRECT,
            )?,
            carried: allocator.storage::<[u32; 4]>("carried", carried, BufferUsages::empty())?,
            tiles,
            points_of_pixel,
            carries,
            has_layers: layers,
            memory,
        })
    }

    /// `former`, or new memory if `former` is shared or too small.
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

    /// Points of one pixel.
    pub(super) fn points_of_pixel(&self) -> u32 {
        self.points_of_pixel
    }

    /// Lists of the points that are lit, with the workgroup counts of their dispatches.
    pub(super) fn point_lists(&self) -> &Buffer {
        &self.point_lists
    }

    /// Tiles that have translucent casters, with the workgroup counts of a dispatch over them.
    pub(super) fn layered_tiles(&self) -> &Buffer {
        &self.layered_tiles
    }

    pub(super) fn resources(&self) -> Resources<'_> {
        Resources::new()
            .with("seen_pixels", &self.seen)
            .with("layers", &self.layers)
            .with("points", &self.points)
            .with("lit", &self.lit)
            .with("point_lists", &self.point_lists)
            .with("layered_tiles", &self.layered_tiles)
            .with("carried", &self.carried)
    }
}
