//! Twin of `wgsl/state/depth.wgsl`: opaque, cutout and dithered casters -> opaque depth `Z`.
use super::{
    caster_hit::{Hit, Records, Target},
    tile::{Tile, TileTexels},
};
use crate::{
    model::{Material, Transfer},
    records::Footprint,
};
use glam::Vec2;

/// Whether a hit of an `opaque` or `cutout` material is solid; the picture blends dithered ones.
pub(super) fn is_solid(material: &Material, hit: &Hit) -> bool {
    match material.transfer {
        Transfer::Opaque => true,
        Transfer::Cutout => hit.opacity >= material.cutoff,
        _ => false,
    }
}

/// Whether a hit of an opaque material blocks the light at `texel`.
fn blocks(target: &Target<'_>, texel: Vec2, hit: &Hit) -> bool {
    match target.material.transfer {
        Transfer::Dither => hit.opacity > target.threshold(texel),
        _ => is_solid(target.material, hit),
    }
}

/// Opaque depth whose last bit marks a dithered surface: `filter` fills holes of dithered surfaces only.
pub(super) fn stored_depth(target: &Target<'_>, hit: &Hit) -> f32 {
    let dithered = target.material.transfer == Transfer::Dither;
    f32::from_bits(hit.depth.to_bits() & !1 | u32::from(dithered))
}

/// Whether a stored opaque depth belongs to a dithered surface.
pub fn is_dithered(depth: f32) -> bool {
    depth.to_bits() & 1 == 1
}

/// Least depth of the solid hits of a tile's texels, 1 if there is none.
pub fn occlude<'a>(
    records: Records<'_>,
    tile: &Tile,
    footprints: impl Iterator<Item = &'a Footprint>,
) -> TileTexels<f32> {
    let mut nearest = TileTexels::filled(1.0_f32);
    for footprint in footprints {
        let target = Target::new(records, footprint);
        if !target.material.transfer.is_opaque() {
            continue;
        }
        for (place, texel) in target.texels(tile) {
            if let Some(hit) = target.hit(texel, 1.0)
                && blocks(&target, texel, &hit)
            {
                nearest[place] = nearest[place].min(stored_depth(&target, &hit));
            }
        }
    }
    nearest
}
