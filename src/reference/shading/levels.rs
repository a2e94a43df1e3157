//! Twin of `wgsl/levels/`: levels of shadow maps, whose blocks hold the mean light of ever more texels as a
//! function of depth. Prefiltered deep shadows are Lokovic and Veach 2000, section 3.3. Unlike theirs: four
//! nodes at every level, whose depth ranges a block cuts at the longest gaps, and blocks that overlap: each
//! is the mean of 4 x 4 of the level below, by a quadratic B-spline; those of the first level are the means of
//! 2 x 2 texels. Blocks that don't overlap show as beads along thin bars that are slanted against them.
use super::receive::cube_face;
use crate::{
    records::{
        BLOCK_NODES, GpuView, LightRecords, PART_FACE, PackedNode, SKIRT, ViewMaps, level_size,
    },
    reference::{
        curve::{
            DEPTHS,
            mean::{Ramp, add_nodes, merge},
        },
        threads::each,
    },
};
use glam::{IVec2, UVec2, Vec2, Vec3};

/// Shares of four blocks in a row in the block above: a quadratic B-spline is a sum of four of half its width.
const SHARES: [f32; 4] = [0.125, 0.375, 0.375, 0.125];

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
                    let ramps = levels.children(records, maps, i, level, at);
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

    /// Ramps of the texels or blocks below a block.
    fn children(
        &self,
        records: &LightRecords,
        maps: &[ViewMaps],
        leveled: usize,
        level: u32,
        at: IVec2,
    ) -> Vec<Ramp> {
        let children = if level == 1 { 2 } else { 4 };
        let first = 2 * at - (children / 2 - 1);
        let mut all = Vec::new();
        for i in 0..children * children {
            let step = IVec2::new(i % children, i / children);
            let (whose, at, shift) = owner(records, leveled, level - 1, first + step);
            let mut ramps = Vec::new();
            if level == 1 {
                let map = &maps[records.leveled[whose].view as usize];
                let width = records.view_of(whose).size.x as i32;
                of_texel(map, (at.y * width + at.x) as usize, 0.25, &mut ramps);
            } else {
                let share = SHARES[step.x as usize] * SHARES[step.y as usize];
                add_nodes(self.level(whose, level - 1).block(at), share, gain(maps), &mut ramps);
            }
            all.extend(ramps.into_iter().map(|ramp| shift.of(ramp)));
        }
        all
    }
}

fn gain(maps: &[ViewMaps]) -> bool {
    maps.iter().any(|map| map.curve.as_ref().is_some_and(|curve| curve.gain))
}

/// Source of a block, or of a texel at level 0: leveled view, block, and map from its depths to this face's.
/// Beyond the edge of a cube's face it is a block of the neighbour, else the nearest block.
fn owner(records: &LightRecords, leveled: usize, level: u32, at: IVec2) -> (usize, IVec2, Shift) {
    let view = records.view_of(leveled);
    let nearest = at.clamp(IVec2::ZERO, last_block(view, level));
    if nearest == at || view.part != PART_FACE {
        return (leveled, nearest, Shift::NONE);
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
    let there = (place / edge).floor().as_ivec2();
    (other, there.clamp(IVec2::ZERO, last_block(face, level)), shift)
}

fn last_block(view: &GpuView, level: u32) -> IVec2 {
    level_size(view.size.as_uvec2(), level).as_ivec2() - 1
}

/// Light depth in fixed point.
fn fixed(depth: f32) -> u32 {
    ((depth * DEPTHS).round_ties_even() as u32).clamp(1, 65535)
}

fn of_texel(map: &ViewMaps, i: usize, share: f32, ramps: &mut Vec<Ramp>) {
    let mut left = Vec3::ONE;
    if let Some(curve) = &map.curve {
        left = add_nodes(curve.nodes_of(i), share, curve.gain, ramps);
    } else if map.nearest[i] < 1.0 {
        let light = Vec3::from_array(map.filter[i]);
        ramps.push(Ramp {
            start: fixed(map.nearest[i]),
            length: 0.0,
            drop: (left - light) * share,
        });
        left = light;
    }
    let mut block = |depth: f32, channels: Vec3| {
        if depth < 1.0 {
            ramps.push(Ramp { start: fixed(depth), length: 0.0, drop: left * channels * share });
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
