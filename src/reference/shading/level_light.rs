//! Twin of `wgsl/shade/level_light.wgsl` and `fade.wgsl`: light of a window of a level's blocks, and of texels
//! before the depths where a level hands over to the next.
//!
//! There, each occluder counts with a share that falls linearly over a range of depths, the *fade*. A block's
//! ramp has the mean depth of its texels', and so the same share. Split at one depth, ramps of different
//! lengths would have different shares, and the shadow a bright line.
use super::{
    Lighting,
    levels::{Block, Level},
    spot::{Spot, Windows, cover},
};
use crate::{
    records::PackedNode,
    reference::curve::{DEPTHS, unpack},
};
use glam::{IVec2, Vec2, Vec3};

/// Smallest change of light that counts as an occluder.
pub const NOTHING: f32 = 1e-3;
/// Distance from a block's middle that a plane's ramp in it spans [blocks]; half a block at the first level,
/// whose blocks don't overlap.
pub const BLOCK_REACH: f32 = 1.0;

/// Light of a level's blocks, averaged over the window.
#[derive(Default)]
pub(super) struct LevelLight {
    /// Light before the level's depths, light that they remove, and light behind them.
    pub(super) before: Vec3,
    pub(super) taken: Vec3,
    pub(super) behind: Vec3,
    /// The most that can be left of `before`.
    pub(super) most: Vec3,
    /// First depth behind the level's that removes light.
    pub(super) next: Option<f32>,
}

/// Nodes of a block, without the second pair if all of it is behind the receiver.
pub(super) fn nodes_before(block: &Block, end: f32) -> &[PackedNode] {
    let start = (block[1][0] >> 16) as f32;
    if start > 0.0 && start < end { block } else { &block[..2] }
}

impl Spot<'_> {
    /// First depth [fixed point] from `from` on at which blocks of a level around the point remove light, and
    /// the least light that a block has there. `beyond`: how far behind the receiver's end a filter counts,
    /// which may touch the receiver.
    pub(super) fn next_occluder(
        &self,
        level: &Level,
        edge: f32,
        from: f32,
        around: f32,
        beyond: f32,
    ) -> (Option<f32>, f32) {
        let corner = (self.center / edge - 0.5).floor().as_ivec2();
        let (mut next, mut least_open) = (f32::INFINITY, 1.0_f32);
        for i in 0..4 {
            let at = corner + IVec2::new(i % 2, i / 2);
            let end = self.end((at.as_vec2() + 0.5) * edge, around * edge);
            let (mut left, mut open) = (Vec3::ONE, Vec3::ONE);
            for &node in nodes_before(level.block(at), end + beyond) {
                let (start, length, light) = unpack(node, self.gain);
                let last = if light.max_element() > 0.0 { end + beyond } else { end };
                let takes = (left - light).abs().max_element() > NOTHING;
                left = light;
                if start > 0.0 && start + length < from {
                    open = light;
                }
                let first = start.max(from);
                if start > 0.0 && takes && start + length >= from && first < last {
                    next = next.min(first);
                }
            }
            least_open = least_open.min(open.max_element());
        }
        ((next < f32::INFINITY).then_some(next), least_open)
    }

    /// Evaluates the depths from the fade `since` to the fade `to` on a level; `spot` is the radius of their
    /// widest spot [texels].
    pub(super) fn evaluate(
        &self,
        level: &Level,
        edge: f32,
        spot: f32,
        since: [f32; 2],
        to: [f32; 2],
    ) -> LevelLight {
        let middle = self.turn(self.center / edge - 0.5);
        let windows = self.windows(spot, self.radius_at(to[1]), edge);
        let [width, _, least] = windows.widths;
        let half = 0.5 * (width + 1.0);
        let low = (middle.y - half.y).ceil();
        let rows = ((middle.y + half.y).floor() - low + 1.0) as i32;
        let reach = if edge == 2.0 { 1.0 } else { BLOCK_REACH * edge };
        let mut light = LevelLight::default();
        for row in 0..rows {
            let y = low + row as f32;
            let sheared = self.shear * (y - middle.y);
            let first = (middle.x + sheared - half.x).ceil();
            let count = ((middle.x + sheared + half.x).floor() - first + 1.0) as i32;
            for i in 0..count {
                let column = first + i as f32;
                let off = Vec2::new(column - sheared, y) - middle;
                let at = self.turn(Vec2::new(column, y));
                let end = self.end((at + 0.5) * edge, reach);
                let block = level.block(at.as_ivec2());
                self.add_block(&mut light, block, off, &windows, [since, to], end);
            }
        }
        // The light left in a narrower window is part of that in the widest: at most as much per area.
        light.most = light.behind * (width / least).element_product();
        light
    }

    fn add_block(
        &self,
        light: &mut LevelLight,
        block: &Block,
        off: Vec2,
        windows: &Windows,
        [since, to]: [[f32; 2]; 2],
        end: f32,
    ) {
        let weight = cover(off, windows.widths[0]);
        let (mut before, mut behind) = (Vec3::ONE, Vec3::ONE);
        let mut left = Vec3::ONE;
        for &node in nodes_before(block, end) {
            let (start, length, node_light) = unpack(node, self.gain);
            let length = length.max(1.0);
            let drop = if start > 0.0 { left - node_light } else { Vec3::ZERO };
            left = node_light;
            let next = start.max(to[0]);
            if drop.abs().max_element() > NOTHING && start + length > to[0] && next < end {
                light.next = Some(light.next.map_or(next, |least| least.min(next)));
            }
            let stop = end.clamp(start, start + length);
            let shares = [since, to].map(|fade| share_before(fade, start, stop, length));
            before -= drop * shares[0];
            behind -= drop * shares[1];
            let spot = self.radius_at(start + length * 0.5 * (shares[0] + shares[1]));
            let covered = windows.cover(off, spot);
            light.taken += drop * ((shares[1] - shares[0]) * covered);
        }
        light.before += before * weight;
        light.behind += behind * weight;
    }
}

/// Share of the ramp from `start` on, of a length, that counts as before a fade, from the light on; of the part
/// up to `stop`.
pub(super) fn share_before([low, high]: [f32; 2], start: f32, stop: f32, length: f32) -> f32 {
    let inside = [start, stop].map(|depth| depth.clamp(low, high));
    let [first, last] = inside.map(|depth| (high - depth) / (high - low).max(1e-3));
    let whole = (stop.min(low) - start).max(0.0);
    ((whole + (inside[1] - inside[0]) * 0.5 * (first + last)) / length).clamp(0.0, 1.0)
}

/// Share of a surface that counts as before a fade. Depth 1 is none.
fn surface_before([low, high]: [f32; 2], depth: f32) -> f32 {
    let share = (high - depth * DEPTHS) / (high - low).max(1e-3);
    if depth < 1.0 { share.clamp(0.0, 1.0) } else { 0.0 }
}

impl Lighting<'_> {
    /// Light of a texel before a fade.
    pub(super) fn light_before(&self, view: usize, texel: Vec2, fade: [f32; 2]) -> Vec3 {
        let size = self.records.views[view].size;
        let at = texel.clamp(Vec2::ZERO, size - 1.0).as_uvec2();
        let (map, i) = (&self.maps[view], (at.y * size.x as u32 + at.x) as usize);
        let (mut left, mut light) = (Vec3::ONE, Vec3::ONE);
        if let Some(curve) = &map.curve {
            for &node in curve.nodes_of(i) {
                let (start, length, behind) = unpack(node, curve.gain);
                let length = length.max(1.0);
                if start > 0.0 {
                    light -= (left - behind) * share_before(fade, start, start + length, length);
                    left = behind;
                }
            }
        } else if map.nearest[i] < 1.0 {
            left = Vec3::from_array(map.filter[i]);
            light -= (Vec3::ONE - left) * surface_before(fade, map.nearest[i]);
        }
        let solid = map.colored.get(i).copied().unwrap_or([map.opaque[i]; 3]);
        light - left * Vec3::from_array(solid.map(|depth| surface_before(fade, depth)))
    }
}
