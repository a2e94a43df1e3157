//! Twin of `wgsl/shade/nearest_lit.wgsl`: what occluders let through that another one hides from the light's
//! centre.
//!
//! A map holds nothing behind an opaque occluder, but light from the rest of the area gets there. It meets what
//! the light meets beside the occluder: levels are asked from fine to coarse until a block around the point is
//! lit, then back to the finest along the lit blocks that are nearest to the point. Coarse blocks alone would
//! not tell the receiver's own surface from an occluder close to it.
use super::{
    level_light::{nodes_before, share_before},
    levels::{Block, Levels},
    soft::LEAST,
    spot::Spot,
};
use crate::reference::curve::unpack;
use glam::{Vec2, Vec3};

/// Least light of a lit block.
pub const LIT: f32 = 0.25;
/// Part of a fade over which the share of occluders before it falls here: blocks of one that has much of its share
/// behind are lit, and dark at the receiver.
pub const EARLY: f32 = 0.1;
/// Share of the brightest channel below which a channel has no share of its own.
pub const DIM: f32 = 0.01;

impl Spot<'_> {
    /// Share of the light behind a fade that reaches the receiver, in the nearest lit block; levels are asked
    /// from `first` on.
    pub(super) fn nearest_lit(
        &self,
        levels: &Levels,
        leveled: usize,
        [first, last]: [u32; 2],
        since: [f32; 2],
    ) -> Vec3 {
        let (mut number, mut place, mut share) = (first, self.center, Vec3::ONE);
        let mut is_found = false;
        let since = [since[0], since[0] + EARLY * (since[1] - since[0])];
        while number > 0 && number <= last {
            let (level, edge) = (levels.level(leveled, number), (1 << number) as f32);
            let corner = (place / edge - 0.5).floor();
            let mut nearest = f32::INFINITY;
            for i in 0..4 {
                let at = corner + Vec2::new((i % 2) as f32, (i / 2) as f32);
                let middle = (at + 0.5) * edge;
                let end = self.end(middle, if number == 1 { 1.0 } else { edge });
                let [before, here] = self.light_at(level.block(at.as_ivec2()), since, end);
                let away = (middle - self.center).length_squared();
                let open = before.max_element();
                if open > LIT && away < nearest {
                    nearest = away;
                    place = middle;
                    let mean = Vec3::splat(here.max_element() / open);
                    let own = here / before.max(Vec3::splat(LEAST));
                    share = Vec3::select(before.cmplt(Vec3::splat(DIM * open)), mean, own);
                }
            }
            let is_lit = nearest < f32::INFINITY;
            // A lit block whose children around its middle are dark is the finest to know.
            let is_last = is_found && !is_lit;
            is_found |= is_lit;
            number = if is_last {
                0
            } else if is_found {
                number - 1
            } else {
                number + 1
            };
        }
        share
    }

    /// Light of a block before a fade, and at the receiver.
    fn light_at(&self, block: &Block, since: [f32; 2], end: f32) -> [Vec3; 2] {
        let (mut left, mut light) = (Vec3::ONE, [Vec3::ONE; 2]);
        for &node in nodes_before(block, end) {
            let (start, length, node_light) = unpack(node, self.gain);
            let length = length.max(1.0);
            let drop = if start > 0.0 { left - node_light } else { Vec3::ZERO };
            left = node_light;
            let before = share_before(since, start, start + length, length);
            let here = (end.clamp(start, start + length) - start) / length;
            light[0] -= drop * before;
            light[1] -= drop * here.max(before);
        }
        light
    }
}
