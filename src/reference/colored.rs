//! Twin of `wgsl/state/colored.wgsl` and `wgsl/soften/colored_*.wgsl`: coloured dithering. Each channel has
//! its own threshold and its own opaque depth, so that three depths hold coloured layers in any order
//! (McGuire and Enderton 2011).
use super::{
    caster_hit::{Hit, Records, Target},
    filter::{around, stored, texels},
    occlude::{is_dithered, is_solid, stored_depth},
    tile::{Tile, TileTexels},
};
use crate::{
    model::Transfer,
    records::{Footprint, ViewMaps},
};
use glam::{BVec3, Vec2, Vec3};

/// Channels of the light that a hit of an opaque material blocks: those whose `1 - T` exceeds their own
/// threshold.
fn blocked_channels(target: &Target<'_>, texel: Vec2, hit: &Hit) -> BVec3 {
    if target.material.transfer != Transfer::Dither {
        return BVec3::splat(is_solid(target.material, hit));
    }
    (1.0 - hit.light).cmpgt(Vec3::from_array([0, 1, 2].map(|c| target.channel_threshold(texel, c))))
}

/// Least depth per channel of the hits that block it, for a tile's texels; 1 if there is none.
pub fn occlude_colored<'a>(
    records: Records<'_>,
    tile: &Tile,
    footprints: impl Iterator<Item = &'a Footprint>,
) -> TileTexels<Vec3> {
    let mut nearest = TileTexels::filled(Vec3::ONE);
    for footprint in footprints {
        let target = Target::new(records, footprint);
        if !target.material.transfer.is_opaque() {
            continue;
        }
        for (place, texel) in target.texels(tile) {
            if let Some(hit) = target.hit(texel, 1.0) {
                let blocked = blocked_channels(&target, texel, &hit);
                let depth = Vec3::splat(stored_depth(&target, &hit));
                nearest[place] = Vec3::select(blocked, nearest[place].min(depth), nearest[place]);
            }
        }
    }
    nearest
}

/// Summary of a run of texels.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Share of the window that dithered surfaces block, per channel.
    blocked: Vec3,
    /// Depth of the nearest dithered surface, 1 for none.
    nearest: f32,
    /// Depth behind the closest hole, negative for none, and its distance [texels].
    hole: f32,
    distance: f32,
}

impl Run {
    const EMPTY: Self = Self { blocked: Vec3::ZERO, nearest: 1.0, hole: -1.0, distance: 1e6 };

    /// Run of one texel. An opaque surface that is not dithered has the same depth in every channel, behind
    /// the dithered ones.
    fn of(depths: [f32; 3]) -> Self {
        let dithered = BVec3::from_array(depths.map(is_dithered));
        let depths = Vec3::from_array(depths);
        let hole = if dithered.all() { -1.0 } else { depths.max_element() };
        Self {
            blocked: Vec3::select(dithered, Vec3::ONE, Vec3::ZERO),
            nearest: Vec3::select(dithered, depths, Vec3::ONE).min_element(),
            hole,
            distance: if dithered.all() { 1e6 } else { 0.0 },
        }
    }

    fn sum(runs: impl Iterator<Item = (f32, Self, u32)>) -> Self {
        runs.fold(Self::EMPTY, |mut sum, (weight, run, away)| {
            sum.blocked += weight * run.blocked;
            sum.nearest = sum.nearest.min(run.nearest);
            let distance = run.distance + away as f32;
            if distance < sum.distance {
                (sum.hole, sum.distance) = (run.hole, distance);
            }
            sum
        })
    }
}

/// Like [`super::filter::filter`], for maps with depths per channel; the result has none.
pub fn filter_colored(maps: &mut ViewMaps, window: u32) {
    let (radius, size) = ((window / 2) as i32, maps.view.size);
    if radius == 0 {
        return;
    }
    let colored = std::mem::take(&mut maps.colored);
    let rows: Vec<Run> = texels(size)
        .map(|(x, y)| {
            let taps = around(size.x, x, radius);
            let run = |x: u32| Run::of(colored[(y * size.x + x) as usize]);
            Run::sum(taps.map(|(weight, x, away)| (weight, run(x), away)))
        })
        .collect();
    for (at, (x, y)) in texels(size).enumerate() {
        let taps = around(size.y, y, radius);
        let row = |y: u32| rows[(y * size.x + x) as usize];
        let run = Run::sum(taps.map(|(weight, y, away)| (weight, row(y), away)));
        for (channel, blocked) in run.blocked.to_array().into_iter().enumerate() {
            if blocked > 0.0 {
                maps.filter[at][channel] = stored(maps.filter[at][channel] * (1.0 - blocked));
            }
        }
        maps.nearest[at] = maps.nearest[at].min(run.nearest);
        if is_dithered(maps.opaque[at]) {
            maps.opaque[at] = if run.hole < 0.0 { 1.0 } else { run.hole };
        }
    }
}
