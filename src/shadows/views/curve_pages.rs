//! Pages of curves: a tile that casters touch has one of a pool, the others have none.
//!
//! A page holds the nodes of a tile's texels. It is named by its place in the texture of curves, as a word:
//! column, row and layers. WGSL: `wgsl/curve/pages.wgsl`, `wgsl/curve/give_pages.wgsl`.
use crate::{
    error::Error,
    gpu::Allocator,
    model::TILE_SIZE,
    shadows::Config,
    stage::curve::{PAGE_BITS, SHORT_PAGE},
    view::NODE_BYTES,
};
use wgpu::{
    Buffer, BufferUsages, Origin3d, Texture,
    TextureFormat::{R32Uint, Rgba32Uint},
    TextureUsages,
};

/// Pages beside each other.
const COLUMNS: u32 = 32;
/// Pages below each other: 8,192 texels, as many as a texture of the core has.
const ROWS: u32 = 512;
/// Pages that every frame has room for: 16 MiB of eight nodes. Atlases of so many tiles have none.
const FREE_PAGES: u32 = 1024;
/// Pages that no tile owns.
const SHARED: u32 = SHORT_PAGE + 1;

/// Pages of an atlas.
#[derive(Clone, Debug)]
pub struct CurvePages {
    /// Page of each tile of the atlas, r32uint.
    pub table: Texture,
    /// Number of free pages, then these.
    pub(in crate::shadows) free: Buffer,
    /// Pages that tiles may have.
    pub(in crate::shadows) count: u32,
}

/// Word of page `number`.
fn word(number: u32) -> u32 {
    let (column, row) = (number % COLUMNS, number / COLUMNS % ROWS);
    column | (row << PAGE_BITS) | ((number / (COLUMNS * ROWS)) << (2 * PAGE_BITS))
}

/// First texel and layer of a page, whose texels have `pairs` layers; none of those that no tile owns.
pub(in crate::shadows) fn place(page: u32, pairs: u32) -> Option<Origin3d> {
    let texel = |bits: u32| (page >> bits) % (1 << PAGE_BITS) * TILE_SIZE;
    let origin =
        Origin3d { x: texel(0), y: texel(PAGE_BITS), z: (page >> (2 * PAGE_BITS)) * pairs };
    (page >= SHARED).then_some(origin)
}

impl CurvePages {
    /// The pages of no tile. `tiles`: of the atlas, in x, y and layers.
    pub(in crate::shadows) fn new(
        allocator: &mut Allocator<'_>,
        tiles: [u64; 3],
    ) -> Result<Self, Error> {
        let usage = TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC;
        let table = allocator.texture("curve_pages", R32Uint, tiles, usage)?;
        let free = allocator.filled("free_pages", &[0_u32; 2], BufferUsages::STORAGE);
        Ok(Self { table, free, count: 0 })
    }

    /// At least `count` for tiles, and the texture that they are in, for curves of `nodes` nodes.
    pub(in crate::shadows) fn with_pages(
        self,
        allocator: &mut Allocator<'_>,
        count: u32,
        nodes: u32,
    ) -> Result<(Self, Texture), Error> {
        let rows = (SHARED + count).div_ceil(COLUMNS);
        let all = rows * COLUMNS;
        let count = all - SHARED;
        let words: Vec<u32> = std::iter::once(count).chain((SHARED..all).map(word)).collect();
        let [columns, high, layers] =
            [COLUMNS * TILE_SIZE, rows.min(ROWS) * TILE_SIZE, rows.div_ceil(ROWS) * nodes / 2];
        let usage =
            TextureUsages::STORAGE_BINDING | TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let size = [columns, high, layers].map(u64::from);
        let curves = allocator.texture("curves", Rgba32Uint, size, usage)?;
        let free = allocator.filled("free_pages", &words, BufferUsages::STORAGE);
        Ok((Self { free, count, ..self }, curves))
    }

    /// Whether there are as many as are expected to be needed, or one for each tile.
    pub(in crate::shadows) fn suffice(&self, expected: Option<u32>) -> bool {
        self.count >= expected.unwrap_or(0).min(self.tile_count()) || !self.exist()
    }

    /// Whether curves are in pages.
    pub(in crate::shadows) fn exist(&self) -> bool {
        self.tile_count() > 1
    }

    /// Whether curves of so many tiles are to be in pages: not where the memory is little anyway, nor where
    /// pages for all of them would exceed the budget.
    pub(in crate::shadows) fn are_worth(config: &Config, tiles: u64) -> bool {
        let page = u64::from(TILE_SIZE * TILE_SIZE * config.nodes()) * NODE_BYTES;
        let all = (tiles + u64::from(SHARED)).next_multiple_of(COLUMNS.into()) * page;
        config.counts_curves() && tiles > FREE_PAGES.into() && all <= config.settings.curve_budget
    }

    /// Pages for all tiles that are expected to need one, or for a quarter of all.
    pub(in crate::shadows) fn room(&self, expected: Option<u32>) -> u32 {
        let tiles = self.tile_count();
        expected.unwrap_or(tiles / 4).max(FREE_PAGES).min(tiles)
    }

    /// Most pages that all tiles of the atlas may have.
    pub(in crate::shadows) fn tile_count(&self) -> u32 {
        let size = self.table.size();
        size.width * size.height * size.depth_or_array_layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stage::curve::BLANK_PAGE;
    use std::collections::BTreeSet;

    #[test]
    fn every_page_has_a_place_of_its_own() {
        let all = 3 * COLUMNS * ROWS;
        let places: Vec<_> = (SHARED..all).filter_map(|number| place(word(number), 4)).collect();
        let apart: BTreeSet<_> = places.iter().map(|place| [place.x, place.y, place.z]).collect();
        assert_eq!(apart.len() as u32, all - SHARED);
        assert_eq!([BLANK_PAGE, SHORT_PAGE].map(word), [BLANK_PAGE, SHORT_PAGE]);
        assert_eq!(places.iter().map(|place| place.y).max(), Some((ROWS - 1) * TILE_SIZE));
        assert_eq!(places.iter().map(|place| place.z).max(), Some(8));
    }
}
