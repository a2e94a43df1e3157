//! CPU reference of `wgsl/shade/taps.wgsl`: texels of a look-up, and their weights.
use super::Lighting;
use glam::{UVec2, Vec2, Vec3};
use gobo::records::{FILTER_BOX, FILTER_DISC, FILTER_SPLINE, GpuLight, RADIUS_STEPS, SPLINE_REACH};
use std::f32::consts::TAU;

/// Rotation from each texel of a disc to the next (Vogel 1979): cosine and sine of the golden angle.
pub const GOLDEN: Vec2 = Vec2::new(-0.737_368_9, 0.675_490_3);

/// Direction to a disc's first texel, unit: rotated evenly by the pixel (Roberts 2018, the R2 sequence), the
/// same in every frame.
pub(super) fn turn(pixel: UVec2) -> Vec2 {
    let sum = pixel.x.wrapping_mul(12_664_745).wrapping_add(pixel.y.wrapping_mul(9_560_333));
    Vec2::from_angle((sum & 0xff_ffff) as f32 * (TAU / 16_777_216.0))
}

/// Nine texels of a map around a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Taps {
    /// Map position of the point \[texels\].
    position: Vec2,
    /// Light depth of the point.
    pub z: f32,
    middle: Vec2,
    x: [f32; 3],
    y: [f32; 3],
}

impl Taps {
    /// Position and weight of texel `i`.
    fn tap(&self, i: usize) -> (Vec2, f32) {
        let step = Vec2::new((i % 3) as f32 - 1.0, (i / 3) as f32 - 1.0);
        (self.middle + step, self.x[i % 3] * self.y[i / 3])
    }

    /// Texels and weights of a light's filter. `turn`: direction to a disc's first texel.
    pub(super) fn of(&self, light: &GpuLight, turn: Vec2) -> Vec<(Vec2, f32)> {
        let count = light.taps >> 8 & 0xff;
        let position = self.position.clamp(Vec2::splat(-1e6), Vec2::splat(1e6));
        match light.taps & 0xff {
            FILTER_SPLINE => (0..9).map(|i| self.tap(i)).collect(),
            FILTER_BOX => {
                let (edge, half) = (count + 1, (count + 1) as f32 * 0.5);
                let first = (position - 0.5 - half).floor() + 1.0;
                let texels = (0..edge * edge).map(|i| UVec2::new(i % edge, i / edge).as_vec2());
                let weight = |texel: Vec2| {
                    let over = half - (texel + 0.5 - position).abs();
                    (over.clamp(Vec2::ZERO, Vec2::ONE) / count as f32).element_product()
                };
                texels.map(|cell| (first + cell, weight(first + cell))).collect()
            }
            FILTER_DISC => {
                let weight = 1.0 / count as f32;
                let mut rotation = turn;
                let texel = |i| {
                    let reach = filter_reach(light) * ((i as f32 + 0.5) / count as f32).sqrt();
                    let texel = (position + rotation * reach).floor();
                    rotation = GOLDEN.rotate(rotation);
                    (texel, weight)
                };
                (0..count).map(texel).collect()
            }
            _ => vec![(self.middle, 1.0)],
        }
    }
}

/// Reach of a light's filter: radius of a disc, half the edge of a square \[texels\].
fn filter_reach(light: &GpuLight) -> f32 {
    match light.taps & 0xff {
        FILTER_SPLINE => SPLINE_REACH,
        FILTER_BOX => ((light.taps >> 8 & 0xff) + 1) as f32 * 0.5,
        FILTER_DISC => (light.taps >> 16) as f32 / RADIUS_STEPS,
        _ => 0.5,
    }
}

/// Reach of the light's filter beyond that of the spline \[texels\].
pub(super) fn beyond_spline(light: &GpuLight) -> f32 {
    (filter_reach(light) - SPLINE_REACH).max(0.0)
}

/// How far a point is lifted along its normal where the filter reaches beyond the spline \[texels\]. `slope`:
/// the normal along the view's x and y. A plane's depths in a view change along these; a box reaches as far
/// as its corners.
pub(super) fn wide_lift(light: &GpuLight, slope: Vec2) -> f32 {
    let is_box = light.taps & 0xff == FILTER_BOX;
    let reach = if is_box { slope.abs().element_sum() } else { slope.length() };
    (light.normal_bias + 0.5) * slope.length() + beyond_spline(light) * reach
}

impl Lighting<'_> {
    /// Taps around a point in a view's map; `None` if the point is outside.
    pub(super) fn taps(&self, view: usize, point: Vec3) -> Option<Taps> {
        let view = &self.views[view];
        let p = view.view_from_world.transform_point3(point);
        let distance = -p.z;
        let perspective = view.perspective > 0.0;
        let spread = view.scale / if perspective { distance.max(1e-6) } else { 1.0 };
        let position = Vec2::new(p.x, -p.y) * spread + view.size * 0.5;
        let z = (distance - view.near) / (view.far - view.near);
        let inside = position.cmpge(Vec2::ZERO).all() && position.cmple(view.size).all();
        if !(z >= 0.0 && (inside || perspective)) {
            return None;
        }
        let middle = position.floor().clamp(Vec2::splat(-1e6), Vec2::splat(1e6));
        let t = (position - middle - 0.5).clamp(Vec2::splat(-0.5), Vec2::splat(0.5));
        Some(Taps { position, z, middle, x: spline(t.x), y: spline(t.y) })
    }
}

/// Weights of a quadratic B-spline around t in -0.5..0.5.
pub fn spline(t: f32) -> [f32; 3] {
    [0.5 * (0.5 - t) * (0.5 - t), 0.75 - t * t, 0.5 * (0.5 + t) * (0.5 + t)]
}
