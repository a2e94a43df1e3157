//! Round numbers, which random ones never are: multiples of half a metre, axes, quarter turns, corners and
//! middles.
use crate::common::scenes::Chance;
use gobo::{
    glam::{Vec3, Vec4},
    model::{Light, LightKind},
};

/// Seeded round numbers.
pub(crate) struct Round(Chance);

impl Round {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Chance::new(seed))
    }

    pub(crate) fn one_of<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.0.below(items.len())]
    }

    /// A multiple of a half, from `low` to `high`.
    pub(crate) fn half(&mut self, low: f32, high: f32) -> f32 {
        low + 0.5 * self.0.below((2.0 * (high - low)) as usize + 1) as f32
    }

    /// Each coordinate a multiple of a half, from -`reach` to `reach`.
    pub(crate) fn place(&mut self, reach: f32) -> Vec3 {
        [0; 3].map(|_| self.half(-reach, reach)).into()
    }

    /// Unit direction along an axis, or a diagonal of a square or of a cube.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let way: Vec3 = [0; 3].map(|_| self.one_of(&[-1.0, 0.0, 0.0, 1.0])).into();
            if way != Vec3::ZERO {
                return way.normalize();
            }
        }
    }

    /// A multiple of a quarter turn [radians].
    pub(crate) fn turn(&mut self) -> f32 {
        self.one_of(&[-1.0, 0.0, 0.0, 1.0, 2.0]) * std::f32::consts::FRAC_PI_2
    }

    /// Channels of 0, 0.5 and 1; alpha 0.5 or 1.
    pub(crate) fn color(&mut self) -> Vec4 {
        let rgb: Vec3 = [0; 3].map(|_| self.one_of(&[0.0, 0.5, 1.0])).into();
        rgb.extend(self.one_of(&[0.5, 1.0]))
    }

    /// The centre of a box, the middle of a face or an edge of it, or a corner.
    pub(crate) fn on_box(&mut self, center: Vec3, half: Vec3) -> Vec3 {
        let way: Vec3 = [0; 3].map(|_| self.one_of(&[-1.0, 0.0, 1.0])).into();
        center + half * way
    }

    /// A directional light, a spot and a point light with maps of `size` texels; lamps in two of `places`.
    pub(crate) fn lights(&mut self, places: &[Vec3], size: u32) -> [Light; 3] {
        let spot = LightKind::Spot {
            position: self.one_of(places),
            direction: self.direction(),
            angle: self.one_of(&[60.0_f32, 90.0, 120.0]).to_radians(),
        };
        [
            LightKind::Directional { direction: self.direction() },
            spot,
            LightKind::Point { position: self.one_of(places) },
        ]
        .map(|kind| Light { kind, size: Some(size), ..Light::default() })
    }
}
