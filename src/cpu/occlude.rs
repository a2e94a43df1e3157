//! Twin of `wgsl/occlude_*.wgsl`: opaque, cutout and dithered casters -> opaque depth `Z`.
use super::{
    caster_hit::{Hit, Records, Target},
    tile::{Tile, TileTexels},
};
use crate::{
    caster::{Material, Transfer},
    footprint::Footprint,
};

/// Opacity that a `dither` hit must exceed to block the light.
fn dither_threshold() -> f32 {
    0.5
}

pub(super) fn is_solid(material: &Material, hit: &Hit) -> bool {
    match material.transfer {
        Transfer::Opaque => true,
        Transfer::Cutout => hit.opacity >= material.cutoff,
        Transfer::Dither => hit.opacity > dither_threshold(),
        _ => false,
    }
}

/// The least depth of the solid hits of a tile's texels, 1 where there is none.
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
        for (place, texel) in tile.texels() {
            if let Some(hit) = target.hit(texel, 1.0)
                && is_solid(target.material, &hit)
            {
                nearest[place] = nearest[place].min(hit.depth);
            }
        }
    }
    nearest
}
