//! Tiles that a footprint touches.
use super::{SLACK, TexelBox, scatter_texel};
use glam::Vec2;
use gobo::{
    model::TILE_SIZE,
    records::{GpuView, TileRect},
};

/// Tiles whose texel centres may be in `bounds` and within `circle` \[texels\] of `center`.
pub(crate) fn tile_rect(
    view: &GpuView,
    view_index: u32,
    bounds: TexelBox,
    center: Vec2,
    circle: f32,
    scatter: bool,
) -> Option<TileRect> {
    // Texel i has its centre at i + 0.5.
    let first = (bounds.min - (0.5 + SLACK)).ceil();
    let last = (bounds.max - (0.5 - SLACK)).floor();
    let min = first.max(Vec2::ZERO);
    let max = last.min(view.size - 1.0);
    // Written so that a NaN is outside.
    if !(min.x <= max.x && min.y <= max.y) {
        return None;
    }
    let corner = scatter_texel(center);
    if scatter && first.cmpge(corner).all() && last.cmple(corner + 1.0).all() {
        return Some(TileRect::scattered(view_index));
    }
    let (lo, hi) = (min.as_uvec2() / TILE_SIZE, max.as_uvec2() / TILE_SIZE);
    let mut mask = 0;
    if hi.x - lo.x < 4 && hi.y - lo.y < 4 {
        for y in lo.y..=hi.y {
            for x in lo.x..=hi.x {
                let first = Vec2::new((x * TILE_SIZE) as f32, (y * TILE_SIZE) as f32) + 0.5;
                let outside = center - center.clamp(first, first + (TILE_SIZE - 1) as f32);
                if outside.dot(outside) <= circle * circle {
                    mask |= 1 << ((y - lo.y) * 4 + x - lo.x);
                }
            }
        }
    } else {
        mask = 0xffff;
    }
    (mask != 0).then_some(TileRect {
        corners: lo.x | lo.y << 8 | hi.x << 16 | hi.y << 24,
        mask_view: mask | view_index << 16,
    })
}
