//! CPU reference of `wgsl/records/tile.wgsl` and `lane.wgsl`: the texels of a tile.
use glam::{UVec2, Vec2};
use gobo::{model::TILE_SIZE, records::GpuView};
use std::ops::{Index, IndexMut};

/// Texels of a tile.
pub const TEXELS: usize = (TILE_SIZE * TILE_SIZE) as usize;

/// One value per texel of a tile, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct TileTexels<T>(Vec<T>);

impl<T: Clone> TileTexels<T> {
    /// The same value for all texels.
    pub fn filled(value: T) -> Self {
        Self(vec![value; TEXELS])
    }
}

impl<T> Index<usize> for TileTexels<T> {
    type Output = T;
    fn index(&self, in_tile: usize) -> &T {
        &self.0[in_tile]
    }
}

impl<T> IndexMut<usize> for TileTexels<T> {
    fn index_mut(&mut self, in_tile: usize) -> &mut T {
        &mut self.0[in_tile]
    }
}

/// A tile of a view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// First texel in the view's map.
    pub origin: UVec2,
    /// Size of the view's map \[texels\].
    size: UVec2,
}

impl Tile {
    /// `index`: counted from the view's first tile.
    pub fn new(view: &GpuView, index: u32) -> Self {
        let origin = UVec2::new(index % view.tiles_x, index / view.tiles_x) * TILE_SIZE;
        Self { origin, size: view.size.as_uvec2() }
    }

    /// Indices of the tile's texels that are in the map, with their centres in the map \[texels\].
    pub fn texels(&self) -> impl Iterator<Item = (usize, Vec2)> + use<> {
        self.texels_near(Vec2::ZERO, f32::INFINITY)
    }

    /// Like [`Self::texels`], for those whose centres are at most `reach` from `center` along each axis, and
    /// perhaps some next to them \[texels\].
    pub fn texels_near(
        &self,
        center: Vec2,
        reach: f32,
    ) -> impl Iterator<Item = (usize, Vec2)> + use<> {
        let edge = UVec2::splat(TILE_SIZE).min(self.size.saturating_sub(self.origin));
        let in_tile = center - self.origin.as_vec2();
        // A NaN excludes nothing.
        let first = (in_tile - reach - 1.0).max(Vec2::ZERO).as_uvec2();
        let last = in_tile + reach + 1.0;
        let end =
            |last: f32, edge: u32| if last < edge as f32 { last.max(0.0) as u32 } else { edge };
        let (end_x, end_y) = (end(last.x, edge.x), end(last.y, edge.y));
        let origin = self.origin;
        (first.y..end_y).flat_map(move |y| {
            (first.x..end_x).map(move |x| {
                let texel = origin + UVec2::new(x, y);
                ((y * TILE_SIZE + x) as usize, texel.as_vec2() + 0.5)
            })
        })
    }
}
