//! Partition of a picture: parts, whose tiles are binned together, and bands, whose pixels are shaded
//! together, so that the intermediate data of pixels takes the same memory in any picture.
use crate::stage::shade::{BAND_TILES, Band};
use glam::UVec2;
use gobo::model::TILE_SIZE;

/// Most tiles of a picture with masks that is one band, so that visible surfaces are kept for shading: 1920 x
/// 1080 pixels.
const WHOLE_TILES: u32 = 8192;

/// Tiles of a band for a picture of `tiles`; `at_once`: the picture has one part and one round.
pub(super) fn band_tiles(tiles: UVec2, has_masks: bool, at_once: bool) -> u32 {
    let count = tiles.element_product();
    let is_whole = has_masks && at_once && count <= WHOLE_TILES;
    if is_whole { count.max(BAND_TILES) } else { BAND_TILES }
}

/// Number of pixels in tiles.
pub(super) fn pixels_of(tiles: u32) -> u32 {
    tiles * TILE_SIZE * TILE_SIZE
}

/// A rectangle of tiles of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TileRect {
    pub origin: UVec2,
    pub size: UVec2,
}

impl TileRect {
    /// `tiles`: capacity of a band.
    pub(super) fn band(&self, round: u32, tiles: u32) -> Band {
        let Self { origin, size } = *self;
        Band { origin, size, round, pixel_count: pixels_of(tiles) }
    }

    /// Workgroup grid, one workgroup per tile.
    pub(super) fn groups(&self) -> [u32; 3] {
        [self.size.x, self.size.y, 1]
    }

    /// Cuts the rectangle into rectangles of at most `size` tiles each.
    fn cut(&self, size: UVec2) -> Vec<Self> {
        let count = UVec2::new(self.size.x.div_ceil(size.x), self.size.y.div_ceil(size.y));
        let rect = |i: u32| {
            let first = UVec2::new(i % count.x, i / count.x) * size;
            Self { origin: self.origin + first, size: size.min(self.size - first) }
        };
        (0..count.element_product()).map(rect).collect()
    }

    /// Cuts the rectangle into at least `count` parts: whole rows, or pieces of one row each, as long as
    /// there are tiles.
    pub(super) fn parts(&self, count: u32) -> Vec<Self> {
        let rows = self.size.y / count.max(1);
        let width = self.size.x / count.div_ceil(self.size.y.max(1)).max(1);
        self.cut(UVec2::new(width.max(1), rows.max(1)))
    }

    /// Cuts the rectangle into as few bands as possible of at most `tiles` tiles.
    pub(super) fn bands(&self, tiles: u32) -> Vec<Self> {
        let width = self.size.x.clamp(1, tiles);
        self.cut(UVec2::new(width, (tiles / width).max(1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered(parts: &[TileRect], whole: UVec2) -> Vec<u32> {
        let mut tiles = vec![0; whole.element_product() as usize];
        for part in parts {
            for y in 0..part.size.y {
                for x in 0..part.size.x {
                    let at = part.origin + UVec2::new(x, y);
                    tiles[(at.y * whole.x + at.x) as usize] += 1;
                }
            }
        }
        tiles
    }

    #[test]
    fn every_tile_is_in_one_part_and_one_band() {
        for size in [[1, 1], [60, 34], [7, 300], [300, 2], [256, 256]] {
            let size = UVec2::from_array(size);
            let whole = TileRect { origin: UVec2::ZERO, size };
            for count in [1, 2, 3, 34, 100, 5000, u32::MAX] {
                let parts = whole.parts(count);
                assert!(parts.len() as u32 >= count.min(size.element_product()), "{size} {count}");
                let bands: Vec<_> = parts.iter().flat_map(|part| part.bands(BAND_TILES)).collect();
                assert!(covered(&parts, size).iter().all(|&n| n == 1), "{size} {count}");
                assert!(covered(&bands, size).iter().all(|&n| n == 1), "{size} {count}");
                assert!(bands.iter().all(|band| band.size.element_product() <= BAND_TILES));
            }
        }
    }
}
