//! CPU reference of `wgsl/bloom/*.wgsl`: a share of the light spreads to its surroundings (Jimenez 2014,
//! "Next Generation Post Processing in Call of Duty").
use crate::records::bloom_sizes;
use glam::{IVec2, UVec2, Vec3};

/// Weight of the coarser levels.
pub const BLOOM_SPREAD: f32 = 0.7;
/// Most light of a texel: levels are half floats.
pub const MAX_BLOOM: f32 = 65504.0;

/// A picture, or a smaller level of it.
pub(super) struct Level {
    size: UVec2,
    light: Vec<Vec3>,
}

impl Level {
    pub(super) fn new(size: UVec2, light: Vec<Vec3>) -> Self {
        Self { size, light }
    }

    fn filled(size: UVec2, of: impl Fn(UVec2) -> Vec3) -> Self {
        let texels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| UVec2::new(x, y)));
        Self { size, light: texels.map(of).collect() }
    }

    /// The texel, or the nearest one.
    pub(super) fn at(&self, texel: IVec2) -> Vec3 {
        let texel = texel.clamp(IVec2::ZERO, self.size.as_ivec2() - 1).as_uvec2();
        self.light[(texel.y * self.size.x + texel.x) as usize]
    }

    pub(super) fn halved(&self, size: UVec2) -> Self {
        Self::filled(size, |texel| {
            let taps = (0..16).map(|i| {
                let step = IVec2::new(i & 3, i >> 2);
                let weight = |v: i32| if v == 1 || v == 2 { 3.0 } else { 1.0 };
                let light = self.at(texel.as_ivec2() * 2 - 1 + step).min(Vec3::splat(MAX_BLOOM));
                light * (weight(step.x) * weight(step.y) / 64.0)
            });
            taps.sum()
        })
    }

    /// Bilinear mean at a texel of the finer level.
    fn enlarged(&self, texel: UVec2) -> Vec3 {
        let near = (texel / 2).as_ivec2();
        let far = near + (texel % 2).as_ivec2() * 2 - 1;
        let ahead = 3.0 * self.at(near) + self.at(IVec2::new(far.x, near.y));
        let behind = 3.0 * self.at(IVec2::new(near.x, far.y)) + self.at(far);
        (3.0 * ahead + behind) / 16.0
    }
}

/// A picture's light after bloom, row by row; `share`: spread light.
pub fn bloomed(size: UVec2, light: &[Vec3], share: f32) -> Vec<Vec3> {
    let mut levels = vec![Level::new(size, light.to_vec())];
    for size in bloom_sizes(size) {
        let next = levels[levels.len() - 1].halved(size);
        levels.push(next);
    }
    let spread = levels.into_iter().rev().reduce(|coarse, level| {
        let share = if level.size == size { share } else { BLOOM_SPREAD };
        Level::filled(level.size, |texel| {
            level.at(texel.as_ivec2()).lerp(coarse.enlarged(texel), share)
        })
    });
    spread.map_or_else(Vec::new, |level| level.light)
}
