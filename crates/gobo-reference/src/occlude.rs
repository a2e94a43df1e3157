//! CPU reference of `wgsl/accumulator/{depth,colored}.wgsl`: opaque depth `Z` of opaque, cutout and dithered
//! casters. With coloured dithering each channel has its own threshold and opaque depth, so that three depths
//! hold coloured layers in any order (McGuire and Enderton 2011).
use super::{
    caster_hit::{Hit, Records, Target},
    tile::{Tile, TileTexels},
};
use glam::{BVec3, Vec2, Vec3};
use gobo::{
    model::{Material, Transfer},
    records::Footprint,
};

/// Whether a hit of an `opaque` or `cutout` material is solid; the picture blends dithered casters.
pub(super) fn is_solid(material: &Material, hit: &Hit) -> bool {
    match material.transfer {
        Transfer::Opaque => true,
        Transfer::Cutout => hit.opacity >= material.cutoff,
        _ => false,
    }
}

/// Channels of the light at `texel` that a hit of an opaque material blocks: all, or with coloured dithering
/// those whose `1 - T` exceeds their own threshold.
fn blocked_channels(target: &Target<'_>, texel: Vec2, hit: &Hit, colored: bool) -> BVec3 {
    match target.material.transfer {
        Transfer::Dither if colored => {
            let thresholds = [0, 1, 2].map(|channel| target.channel_threshold(texel, channel));
            (1.0 - hit.light).cmpgt(Vec3::from_array(thresholds))
        }
        Transfer::Dither => BVec3::splat(hit.opacity > target.threshold(texel)),
        _ => BVec3::splat(is_solid(target.material, hit)),
    }
}

/// Opaque depth whose last bit marks a dithered surface: `filter` fills only the holes of dithered surfaces.
fn stored_depth(target: &Target<'_>, hit: &Hit) -> f32 {
    let dithered = target.material.transfer == Transfer::Dither;
    f32::from_bits(hit.depth.to_bits() & !1 | u32::from(dithered))
}

/// Whether a stored opaque depth belongs to a dithered surface.
pub fn is_dithered(depth: f32) -> bool {
    depth.to_bits() & 1 == 1
}

/// Least depth, per channel, of the hits that block a tile's texels; 1 without one.
pub fn occlude<'a>(
    records: Records<'_>,
    tile: &Tile,
    footprints: impl Iterator<Item = &'a Footprint>,
    colored: bool,
) -> TileTexels<Vec3> {
    let mut nearest = TileTexels::filled(Vec3::ONE);
    for footprint in footprints {
        let target = Target::new(records, footprint);
        if !target.material.transfer.is_opaque() {
            continue;
        }
        for (in_tile, texel) in target.texels(tile) {
            if let Some(hit) = target.hit(texel, 1.0) {
                let blocked = blocked_channels(&target, texel, &hit, colored);
                let depth = Vec3::splat(stored_depth(&target, &hit));
                nearest[in_tile] =
                    Vec3::select(blocked, nearest[in_tile].min(depth), nearest[in_tile]);
            }
        }
    }
    nearest
}
