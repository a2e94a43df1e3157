//! Twin of `wgsl/levels/`: levels of shadow maps, whose blocks hold the mean light of ever more texels as a
//! function of depth. Prefiltered deep shadows are Lokovic and Veach 2000, section 3.3. Unlike theirs: four
//! nodes at every level, whose depth ranges a block cuts at the longest gaps.
use super::receive::cube_face;
use crate::{
    records::{BLOCK_NODES, LightRecords, PART_FACE, PackedNode, SKIRT, ViewMaps, level_size},
    reference::{
        curve::{
            DEPTHS,
            mean::{Ramp, add_nodes, merge},
        },
        threads::each,
    },
};
use glam::{IVec2, UVec2, Vec2, Vec3};

/// Share of a block or texel in the block above.
const SHARE: f32 = 0.25;

/// Light as a function of depth, nearest node first.
pub(super) type Block = [PackedNode; BLOCK_NODES];

/// Affine map from one view's depths to another's, in fixed point.
#[derive(Clone, Copy, Debug)]
struct Shift {
    scale: f32,
    offset: f32,
}

impl Shift {
    const NONE: Self = Self { scale: 1.0, offset: 0.0 };

    fn of(self, ramp: Ramp) -> Ramp {
        let start = (ramp.start as f32 * self.scale + self.offset).round_ties_even();
        Ramp { start: start.clamp(1.0, DEPTHS) as u32, length: ramp.length * self.scale, ..ramp }
    }
}

/// One level of a view, its border included.
#[derive(Clone, Debug)]
pub(super) struct Level {
    size: UVec2,
    blocks: Vec<Block>,
}

impl Level {
    /// Block at `at`, counted from the map's first block, clamped to the border.
    pub(super) fn block(&self, at: IVec2) -> &Block {
        let last = self.size.as_ivec2() - 1;
        let at = (at + SKIRT as i32).clamp(IVec2::ZERO, last).as_uvec2();
        &self.blocks[(at.y * self.size.x + at.x) as usize]
    }
}

/// Levels of every leveled view, finest first.
#[derive(Clone, Debug, Default)]
pub(super) struct Levels(Vec<Vec<Level>>);

impl Levels {
    /// `maps`: of all shadow views.
    pub(super) fn new(records: &LightRecords, maps: &[ViewMaps]) -> Self {
        let mut levels = Self(vec![Vec::new(); records.leveled.len()]);
        for level in 1..=records.level_ends.len() as u32 {
            let views =
                (0..records.leveled.len()).filter(|&i| level <= records.leveled[i].level_count);
            for i in views.collect::<Vec<_>>() {
                let own = level_size(records.view_of(i).size.as_uvec2(), level);
                let size = own + 2 * SKIRT;
                let block = |at: usize| {
                    let at = UVec2::new(at as u32 % size.x, at as u32 / size.x);
                    let at = at.as_ivec2() - SKIRT as i32;
                    let (whose, at, shift) = owner(records, i, level, own, at);
                    let ramps = levels.children(records, maps, whose, level, at);
                    let ramps: Vec<_> = ramps.into_iter().map(|ramp| shift.of(ramp)).collect();
                    let mut block = Block::default();
                    merge(&ramps, &mut block, gain(maps));
                    block
                };
                let blocks = each(size.element_product() as usize, block);
                levels.0[i].push(Level { size, blocks });
            }
        }
        levels
    }

    /// Level `level`, from 1 on, of a leveled view.
    pub(super) fn level(&self, leveled: usize, level: u32) -> &Level {
        &self.0[leveled][level as usize - 1]
    }

    /// Ramps of the four texels or blocks below a block.
    fn children(
        &self,
        records: &LightRecords,
        maps: &[ViewMaps],
        leveled: usize,
        level: u32,
        at: UVec2,
    ) -> Vec<Ramp> {
        let size = records.view_of(leveled).size.as_uvec2();
        let last = level_size(size, level - 1) - 1;
        let mut ramps = Vec::new();
        for i in 0..4 {
            let at = (2 * at + UVec2::new(i % 2, i / 2)).min(last);
            if level == 1 {
                let map = &maps[records.leveled[leveled].view as usize];
                of_texel(map, (at.y * size.x + at.x) as usize, &mut ramps);
            } else {
                let block = self.level(leveled, level - 1).block(at.as_ivec2());
                add_nodes(block, SHARE, gain(maps), &mut ramps);
            }
        }
        ramps
    }
}

fn gain(maps: &[ViewMaps]) -> bool {
    maps.iter().any(|map| map.curve.as_ref().is_some_and(|curve| curve.gain))
}

/// Source of a block's values: leveled view, block, and map from its depths to this face's. Beyond the edge
/// of a cube's face it is a block of the neighbour, else the nearest block.
fn owner(
    records: &LightRecords,
    leveled: usize,
    level: u32,
    size: UVec2,
    at: IVec2,
) -> (usize, UVec2, Shift) {
    let last = size.as_ivec2() - 1;
    let nearest = at.clamp(IVec2::ZERO, last);
    let view = records.view_of(leveled);
    if nearest == at || view.part != PART_FACE {
        return (leveled, nearest.as_uvec2(), Shift::NONE);
    }
    let edge = (1 << level) as f32;
    let slope = ((at.as_vec2() + 0.5) * edge - view.size * 0.5) / view.scale;
    let away =
        view.view_from_world.transpose().transform_vector3(Vec3::new(slope.x, -slope.y, -1.0));
    let other = records.leveled[leveled].first_face as usize + cube_face(away);
    let face = records.view_of(other);
    let p = face.view_from_world.transform_vector3(away);
    // Depth along the neighbour's axis per unit of depth along this face's.
    let along = (-p.z).max(1e-6);
    let place = Vec2::new(p.x, -p.y) * (face.scale / along) + face.size * 0.5;
    let range = view.far - view.near;
    let shift = Shift {
        scale: (face.far - face.near) / (along * range),
        offset: (face.near / along - view.near) / range * DEPTHS,
    };
    (other, (place / edge).floor().as_ivec2().clamp(IVec2::ZERO, last).as_uvec2(), shift)
}

/// Light depth in fixed point.
fn fixed(depth: f32) -> u32 {
    ((depth * DEPTHS).round_ties_even() as u32).clamp(1, 65535)
}

fn of_texel(map: &ViewMaps, i: usize, ramps: &mut Vec<Ramp>) {
    let mut left = Vec3::ONE;
    if let Some(curve) = &map.curve {
        left = add_nodes(curve.nodes_of(i), SHARE, curve.gain, ramps);
    } else if map.nearest[i] < 1.0 {
        let light = Vec3::from_array(map.filter[i]);
        ramps.push(Ramp {
            start: fixed(map.nearest[i]),
            length: 0.0,
            drop: (left - light) * SHARE,
        });
        left = light;
    }
    let mut block = |depth: f32, channels: Vec3| {
        if depth < 1.0 {
            ramps.push(Ramp { start: fixed(depth), length: 0.0, drop: left * channels * SHARE });
        }
    };
    match map.colored.get(i) {
        None => block(map.opaque[i], Vec3::ONE),
        Some(&[red, green, blue]) => {
            block(red, Vec3::X);
            block(green, Vec3::Y);
            block(blue, Vec3::Z);
        }
    }
}
