//! CPU reference of `wgsl/sums/scatter.wgsl`: sums over the casters of each texel, to which other shares can
//! be added.
use super::{
    accumulate::VISIBLE_PRESENCE,
    caster_hit::{Hit, Target},
    maps::{SceneRecords, ViewCasters, depth_order},
    project::ProjectParams,
    threads::each,
    tile::{Tile, TileTexels},
};
use glam::{IVec3, UVec2, Vec2, Vec3};
use gobo::{
    model::Scene,
    records::{FIXED_ONE, MAX_TAU, TRIANGLE_BIT, ViewMaps, nearness},
};

/// Fills in [`ViewMaps::sums`] of maps that have opaque depths.
pub fn add_sums(scene: &Scene, maps: &mut [ViewMaps]) {
    let records = SceneRecords::new(scene.casters(), &scene.shadow);
    for maps in maps {
        maps.sums = sums(&records, maps);
    }
}

fn sums(scene: &SceneRecords<'_>, maps: &ViewMaps) -> Vec<[u32; 4]> {
    let width = maps.view.size.x;
    let view = maps.view.to_gpu(0, UVec2::ZERO, 0);
    let tiles = maps.view.tiles().element_product();
    let params = ProjectParams { scatter: false, include_non_casters: false, by_distance: false };
    let casters = scene.project(&view, params);
    let bins = casters.bins(&depth_order(&casters.keys), &view, tiles, u32::MAX);
    let ViewCasters { footprints, gaussians, setups, .. } = casters;
    let records = scene.hit_records(&view, &gaussians, &setups);
    let at = |texel: Vec2| (texel.y as u32 * width + texel.x as u32) as usize;
    let of_tiles = each(tiles as usize, |index| {
        let tile = Tile::new(&view, index as u32);
        let mut sums = TileTexels::filled([0; 4]);
        for pair in bins.tile(index) {
            let footprint = &footprints[pair.footprint as usize];
            let target = Target::new(records, footprint);
            if !target.filters() {
                continue;
            }
            let is_triangle = footprint.caster & TRIANGLE_BIT != 0;
            let seed = if is_triangle { footprint.caster } else { target.id };
            for (in_tile, texel) in target.texels(&tile) {
                let (sum, end) = (&mut sums[in_tile], maps.opaque[at(texel)]);
                if let Some(face) = target.face(texel, end) {
                    add(sum, face.crossing().tau);
                }
                if let Some(hit) = target.hit(texel, end).filter(|hit| hit.depth < end) {
                    add(sum, rounded_tau(&hit, seed));
                    if hit.presence >= VISIBLE_PRESENCE {
                        sum[3] = sum[3].max(nearness(hit.depth));
                    }
                }
            }
        }
        sums
    });
    let mut all = vec![[0; 4]; maps.opaque.len()];
    for (index, sums) in of_tiles.iter().enumerate() {
        for (in_tile, texel) in Tile::new(&view, index as u32).texels() {
            all[at(texel)] = sums[in_tile];
        }
    }
    all
}

fn add(sum: &mut [u32; 4], tau: IVec3) {
    for (sum, tau) in sum.iter_mut().zip(tau.to_array()) {
        *sum = sum.wrapping_add(tau.cast_unsigned());
    }
}

/// Optical depth in fixed point, with dithered rounding, so that the rounding errors of equal casters do not
/// add up.
fn rounded_tau(hit: &Hit, seed: u32) -> IVec3 {
    let turn = seed.wrapping_mul(2_654_435_769);
    let chance = [0, 0x5555_5555, 0xaaaa_aaaa_u32].map(|third| {
        let bits = turn.wrapping_add(third);
        (bits >> 8) as f32 / (1 << 24) as f32
    });
    let tau = hit.absorbed.map(|x| -(-x.min(1.0 - 1e-9)).ln_1p()).min(Vec3::splat(MAX_TAU));
    (tau * FIXED_ONE + Vec3::from_array(chance)).floor().as_ivec3()
}
