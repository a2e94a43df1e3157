//! From depth order to tiles.
use gobo::{
    glam::UVec2,
    records::{GpuView, TileRect},
    reference::bin::{TilePair, bin},
};

use crate::common::scenes::flat_view;

fn rect(x0: u32, y0: u32, x1: u32, y1: u32, view: u32) -> TileRect {
    let mut mask = 0;
    for (y, x) in (0..=y1 - y0).flat_map(|y| (0..=x1 - x0).map(move |x| (y, x))) {
        mask |= 1 << (y * 4 + x);
    }
    TileRect { corners: x0 | y0 << 8 | x1 << 16 | y1 << 24, mask_view: mask | view << 16 }
}

/// Two views of 4x4 tiles.
fn views() -> [GpuView; 2] {
    [0, 16].map(|first_tile| flat_view(64, 1.0).to_gpu(first_tile, UVec2::ZERO, 0))
}

#[test]
fn pairs_are_by_tile_and_keep_their_order_within_it() {
    let rects = [rect(0, 0, 1, 1, 0), rect(1, 1, 3, 1, 0), rect(1, 1, 1, 1, 1)];
    let bins = bin(&[1, 2, 0], &rects, &views(), 32, 100);
    let pairs: Vec<_> = bins.pairs.iter().map(|p| (p.tile, p.footprint)).collect();
    assert_eq!(pairs, [(0, 0), (1, 0), (4, 0), (5, 1), (5, 0), (6, 1), (7, 1), (21, 2)]);
    assert_eq!(bins.tile(5), [1, 0].map(|footprint| TilePair { tile: 5, footprint }));
    assert_eq!(bins.tile_starts.len(), 33);
    assert!(bins.tile(31).is_empty() && bins.overflowed.is_empty());
}

#[test]
fn what_does_not_fit_emits_nothing_and_is_listed() {
    let rects = [rect(0, 0, 1, 1, 0), rect(1, 1, 3, 1, 0), rect(1, 1, 1, 1, 1)];
    let bins = bin(&[0, 1, 2], &rects, &views(), 32, 6);
    assert_eq!(bins.overflowed, [1, 2]);
    assert!(bins.pairs.iter().all(|pair| pair.footprint == 0) && bins.pairs.len() == 4);
    let bins = bin(&[0, 1, 2], &rects, &views(), 32, 8);
    assert!(bins.overflowed.is_empty() && bins.pairs.len() == 8);
}

#[test]
fn a_scattered_caster_has_no_tiles() {
    let scattered = TileRect::scattered(3);
    assert!(scattered.is_scattered() && scattered.view() == 3 && scattered.tiles().count() == 0);
    let corner = rect(255, 255, 255, 255, 0);
    assert!(!corner.is_scattered() && corner.tiles().eq([(255, 255)]));
    assert!(!TileRect::EMPTY.is_scattered());
}
