//! CPU reference of `wgsl/bin/bin_*.wgsl`: depth-sorted footprints -> pairs by tile, front to back.
//!
//! count -> scan -> emit in sorted order, then a stable sort by tile.
use gobo::records::{GpuView, Outline, TileRect};

/// A footprint that may touch a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TilePair {
    /// `view.first_tile + y * view.tiles_x + x`.
    pub tile: u32,
    /// Index of the footprint.
    pub footprint: u32,
}

/// The pairs of a batch of views.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bins {
    /// Pairs sorted by tile; within a tile by depth key, then by footprint.
    pub pairs: Vec<TilePair>,
    /// Index of each tile's first pair; the number of pairs at the end.
    pub tile_starts: Vec<u32>,
    /// Footprints whose pairs did not all fit, in depth order; `pairs` holds none of their pairs.
    pub overflowed: Vec<u32>,
}

impl Bins {
    /// The pairs of a tile.
    pub fn tile(&self, tile: usize) -> &[TilePair] {
        &self.pairs[self.tile_starts[tile] as usize..self.tile_starts[tile + 1] as usize]
    }
}

/// Bins footprints. `sorted`: visible footprints by depth key; `rects`: of all footprints; `outline`: of a
/// footprint, if it is a Gaussian's.
pub fn bin<'a>(
    sorted: &[u32],
    rects: &[TileRect],
    outline: impl Fn(u32) -> Option<&'a Outline>,
    views: &[GpuView],
    tile_count: u32,
    pair_budget: u32,
) -> Bins {
    let mut bins = Bins::default();
    let mut emitted = Vec::new();
    let mut counts = vec![0_u32; tile_count as usize];
    // 64 bits, as the number of pairs may be far above the capacity.
    let mut offset = 0_u64;
    for &footprint in sorted {
        let rect = &rects[footprint as usize];
        let view = &views[rect.view() as usize];
        let count = rect.tiles(outline(footprint)).count() as u64;
        let fits = offset + count <= u64::from(pair_budget);
        offset += count;
        if !fits {
            bins.overflowed.push(footprint);
            continue;
        }
        for (x, y) in rect.tiles(outline(footprint)) {
            let tile = view.first_tile + y * view.tiles_x + x;
            counts[tile as usize] += 1;
            emitted.push(TilePair { tile, footprint });
        }
    }
    bins.tile_starts.push(0);
    for count in counts {
        bins.tile_starts.push(bins.tile_starts[bins.tile_starts.len() - 1] + count);
    }
    let mut offsets = bins.tile_starts.clone();
    bins.pairs = emitted.clone();
    for pair in emitted {
        let offset = &mut offsets[pair.tile as usize];
        bins.pairs[*offset as usize] = pair;
        *offset += 1;
    }
    bins
}
