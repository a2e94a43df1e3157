//! Shadow atlas: one texture array that holds the maps of all views, in rectangles of whole tiles, so that
//! no workgroup writes into a neighbour.
use crate::model::{TILE_SIZE, tiles_of};
use etagere::{AllocatorOptions, AtlasAllocator, size2};
use glam::UVec2;

/// Rectangle of a view's map in the atlas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapSlot {
    /// First texel of the map in its layer.
    pub origin: UVec2,
    /// Layer of the texture array.
    pub layer: u32,
}

/// Limits of an atlas's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtlasLimits {
    /// Longest edge of a layer \[texels\].
    pub edge: u32,
    /// Layers.
    pub layers: u32,
    /// Texels of all layers together.
    pub texels: u64,
}

impl AtlasLimits {
    /// The limits of every WebGPU device.
    pub const CORE: Self = Self { edge: 8192, layers: 256, texels: u64::MAX };

    /// The limits, with at most `texels` in all.
    #[must_use]
    pub fn within(self, texels: u64) -> Self {
        Self { texels, ..self }
    }

    /// The limits of a device.
    pub fn of(limits: &wgpu::Limits) -> Self {
        // Longer edges gain nothing, and the allocator counts in 16 bits.
        let edge = limits.max_texture_dimension_2d.min(16384);
        Self { edge, layers: limits.max_texture_array_layers, texels: u64::MAX }
    }
}

/// An atlas and the position of each map in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Atlas {
    /// Size of a layer \[texels\].
    pub size: UVec2,
    /// Layers.
    pub layers: u32,
    /// Position of each map, in the maps' order.
    pub slots: Vec<MapSlot>,
}

/// Requested size of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wish {
    /// Size of the map \[texels\].
    pub size: UVec2,
    /// Whether the user chose the size: it is halved only as a last resort.
    pub fixed: bool,
}

fn whole_tiles(size: UVec2) -> UVec2 {
    (size + TILE_SIZE - 1) / TILE_SIZE * TILE_SIZE
}

/// Rectangle that a map of `size` texels occupies: whole tiles.
pub(super) fn rectangle(size: UVec2) -> UVec2 {
    tiles_of(size) * TILE_SIZE
}

pub(super) fn area(size: UVec2) -> u64 {
    u64::from(size.x) * u64::from(size.y)
}

impl Atlas {
    /// Packs maps into layers as large as the largest map, or larger if that takes fewer texels or the layers
    /// do not suffice. `None` if the maps do not fit.
    pub fn pack(sizes: &[UVec2], limits: &AtlasLimits) -> Option<Self> {
        let largest = sizes.iter().fold(UVec2::splat(TILE_SIZE), |a, &b| a.max(rectangle(b)));
        // Candidate layer sizes [quarters of the largest map].
        const SHAPES: [[u32; 2]; 8] =
            [[4, 4], [4, 5], [4, 6], [4, 8], [8, 8], [16, 16], [32, 32], [64, 64]];
        let candidates = SHAPES.map(|[x, y]| {
            let grown = whole_tiles(largest * UVec2::new(x, y) / 4);
            grown.min(UVec2::splat(limits.edge / TILE_SIZE * TILE_SIZE))
        });
        let needed: u64 = sizes.iter().map(|&size| area(rectangle(size))).sum();
        let mut best: Option<Self> = None;
        let mut tried = Vec::new();
        for size in candidates {
            if size.cmplt(largest).any() || tried.contains(&size) {
                continue;
            }
            tried.push(size);
            let texels = |layers: u32| area(size) * u64::from(layers);
            let most = best.as_ref().map_or(limits.texels, |best| best.texels() - 1);
            let least_layers = needed.div_ceil(area(size)).max(1);
            if least_layers > u64::from(limits.layers) || least_layers * area(size) > most {
                continue;
            }
            let layer_limit =
                limits.layers.min(u32::try_from(most / area(size)).unwrap_or(u32::MAX));
            if let Some(atlas) = Self::pack_into(size, layer_limit, sizes)
                && texels(atlas.layers) <= most
            {
                best = Some(atlas);
            }
        }
        best
    }

    fn pack_into(size: UVec2, layer_limit: u32, sizes: &[UVec2]) -> Option<Self> {
        let options = AllocatorOptions {
            alignment: size2(TILE_SIZE as i32, TILE_SIZE as i32),
            ..AllocatorOptions::default()
        };
        // Shelves stay tight when the tallest come first.
        let mut order: Vec<usize> = (0..sizes.len()).collect();
        order.sort_by_key(|&i| (u32::MAX - sizes[i].y, u32::MAX - sizes[i].x, i));
        let mut layers: Vec<AtlasAllocator> = Vec::new();
        // Earlier layers are too full for maps as large as the last one.
        let (mut open, mut last) = (0, UVec2::ZERO);
        let mut slots = vec![MapSlot { origin: UVec2::ZERO, layer: 0 }; sizes.len()];
        for i in order {
            let edge = rectangle(sizes[i]);
            if edge != last {
                (open, last) = (0, edge);
            }
            let wanted = size2(edge.x as i32, edge.y as i32);
            let found = loop {
                if open == layers.len() {
                    if open as u32 == layer_limit {
                        return None;
                    }
                    let whole = size2(size.x as i32, size.y as i32);
                    layers.push(AtlasAllocator::with_options(whole, &options));
                }
                if let Some(found) = layers[open].allocate(wanted) {
                    break found.rectangle.min;
                }
                // An empty layer always fits the largest map.
                if layers[open].is_empty() {
                    return None;
                }
                open += 1;
            };
            let origin = UVec2::new(found.x as u32, found.y as u32);
            slots[i] = MapSlot { origin, layer: open as u32 };
        }
        Some(Self { size, layers: (layers.len() as u32).max(1), slots })
    }

    /// Texels of all layers.
    pub fn texels(&self) -> u64 {
        area(self.size) * u64::from(self.layers)
    }
}

/// Halves maps until all fit: always the largest, the last of them first, and maps of a fixed size only as a
/// last resort. Returns how many are smaller than requested. A map of one tile stays, so even then some may
/// not fit.
pub fn shrink_to_fit(wishes: &mut [Wish], limits: &AtlasLimits) -> usize {
    let before = wishes.to_vec();
    loop {
        let sizes: Vec<UVec2> = wishes.iter().map(|wish| wish.size).collect();
        let needed: u64 = sizes.iter().map(|&size| area(rectangle(size))).sum();
        if needed <= limits.texels && Atlas::pack(&sizes, limits).is_some() {
            break;
        }
        let key = |wish: &Wish| (!wish.fixed, area(wish.size));
        let shrinkable = |wish: &&mut Wish| wish.size.max_element() > TILE_SIZE;
        let Some(largest) = wishes.iter_mut().filter(shrinkable).map(|wish| key(wish)).max() else {
            break;
        };
        // As many as needed; where only fragmentation is in the way, a few at a time.
        let excess = needed.saturating_sub(limits.texels);
        let count = excess.div_ceil(largest.1).max(sizes.len() as u64 / 64).max(1);
        let of_largest = wishes.iter_mut().rev().filter(|wish| key(wish) == largest);
        for wish in of_largest.take(usize::try_from(count).unwrap_or(usize::MAX)) {
            wish.size = whole_tiles(wish.size / 2).max(UVec2::splat(TILE_SIZE));
        }
    }
    wishes.iter().zip(&before).filter(|(now, before)| now.size != before.size).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn free(size: u32) -> Wish {
        Wish { size: UVec2::splat(size), fixed: false }
    }

    /// Checks that every rectangle is within its layer and overlaps no other.
    fn check(atlas: &Atlas, sizes: &[UVec2]) {
        let rectangle = |i: usize| {
            let MapSlot { origin, layer } = atlas.slots[i];
            (layer, origin, origin + rectangle(sizes[i]))
        };
        for i in 0..sizes.len() {
            let (layer, first, end) = rectangle(i);
            assert!(layer < atlas.layers && end.cmple(atlas.size).all(), "{i}");
            assert_eq!(first % TILE_SIZE, UVec2::ZERO, "{i}");
            for j in 0..i {
                let (other, other_first, other_end) = rectangle(j);
                let apart = first.cmpge(other_end).any() || other_first.cmpge(end).any();
                assert!(layer != other || apart, "{i} lies over {j}");
            }
        }
    }

    #[test]
    fn places_lie_apart() {
        for step in 1..40u32 {
            let sizes: Vec<UVec2> =
                (0..60u32).map(|i| 16 + UVec2::new(i * 37 * step, i * 53 * step) % 500).collect();
            let atlas = Atlas::pack(&sizes, &AtlasLimits::CORE).unwrap();
            check(&atlas, &sizes);
            let needed: u64 = sizes.iter().map(|&s| area(rectangle(s))).sum();
            assert!(atlas.texels() < 2 * needed, "{step}: {} for {needed}", atlas.texels());
        }
    }

    #[test]
    fn equal_maps_waste_nothing() {
        for (count, edge) in [(1, 16), (6, 1024), (7, 1008), (200, 512), (512, 256)] {
            let sizes = vec![UVec2::splat(edge); count];
            let atlas = Atlas::pack(&sizes, &AtlasLimits::CORE).unwrap();
            check(&atlas, &sizes);
            assert_eq!(atlas.texels(), count as u64 * area(rectangle(UVec2::splat(edge))));
        }
        assert_eq!(
            Atlas::pack(&[], &AtlasLimits::CORE).map(|a| (a.layers, a.slots)),
            Some((1, vec![]))
        );
    }

    #[test]
    fn few_layers_become_large() {
        let limits = AtlasLimits { edge: 512, layers: 2, texels: u64::MAX };
        let sizes = vec![UVec2::splat(128); 32];
        let atlas = Atlas::pack(&sizes, &limits).unwrap();
        check(&atlas, &sizes);
        assert_eq!((atlas.size, atlas.layers), (UVec2::splat(512), 2));
        assert_eq!(Atlas::pack(&vec![UVec2::splat(128); 33], &limits), None);
        assert_eq!(Atlas::pack(&[UVec2::splat(528)], &limits), None);
    }

    #[test]
    fn what_does_not_fit_is_made_smaller() {
        let limits = AtlasLimits { edge: 512, layers: 2, texels: u64::MAX };
        let mut wishes = [free(512), free(512), free(128)];
        assert_eq!(shrink_to_fit(&mut wishes, &limits), 1);
        assert_eq!(wishes, [free(512), free(256), free(128)]);

        let fixed = Wish { fixed: true, ..free(512) };
        let mut wishes = [fixed, free(256), fixed];
        assert_eq!(shrink_to_fit(&mut wishes, &limits.within(3 * 512 * 512)), 2);
        assert_eq!(wishes, [fixed, free(16), Wish { size: UVec2::splat(256), ..fixed }]);

        // 256 and 64 would do but for the layer around them.
        let mut wishes = [free(512), free(64)];
        assert_eq!(shrink_to_fit(&mut wishes, &limits.within(70_000)), 1);
        assert_eq!(wishes, [free(128), free(64)]);
        let mut wishes = vec![free(1024); 10_000];
        assert_eq!(shrink_to_fit(&mut wishes, &AtlasLimits::CORE.within(1 << 27)), 10_000);
        let texels: u64 = wishes.iter().map(|wish| area(wish.size)).sum();
        assert!(texels > 1 << 26, "far more than needed: {texels}");
        let mut wishes = vec![free(16); 5];
        assert_eq!(shrink_to_fit(&mut wishes, &limits.within(1024)), 0, "as small as can be");
        assert_eq!(shrink_to_fit(&mut [free(512), free(512)], &limits), 0);
    }
}
