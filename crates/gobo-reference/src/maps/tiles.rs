//! Conversions between tiles of different values.
use crate::{
    accumulate::Accumulated,
    curve::tile::CurveTexel,
    tile::{TEXELS, TileTexels},
};
use glam::Vec3;
use gobo::records::NO_OWNER;

/// Depth behind which all channels are blocked.
pub(super) fn last_depths(depths: &TileTexels<Vec3>) -> TileTexels<f32> {
    let mut last = TileTexels::filled(1.0);
    for in_tile in 0..TEXELS {
        last[in_tile] = depths[in_tile].max_element();
    }
    last
}

/// Values that curve mode and nearest-depth mode share.
pub(super) fn without_curves(tile: &TileTexels<CurveTexel>) -> TileTexels<Accumulated> {
    let mut texels = TileTexels::filled(Accumulated::NONE);
    for in_tile in 0..TEXELS {
        let CurveTexel { passed, nearest, .. } = tile[in_tile];
        texels[in_tile] = Accumulated { light: passed, nearest, owner: NO_OWNER };
    }
    texels
}
