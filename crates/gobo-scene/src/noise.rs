//! Animated tileable noise: an alpha texture that scrolls and evolves, for the cutout shadow of flowing
//! smoke.
use super::{numbers::array, painted};
use glam::{IVec2, Vec2};
use gobo::{
    model::{Motion, Scene, Texture},
    records::pcg,
};
use rayon::prelude::*;

/// Kinds of generated textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum KindOfTexture {
    /// White; five octaves of gradient noise (Perlin 2002) are the alpha.
    Noise,
    /// The same in a round window that stands still, so that a quad shows no corners.
    Smoke,
    /// A chessboard of white and rainbow colours.
    Checks,
    /// Upright stripes in rainbow colours.
    Stripes,
    /// Grey: a net of bright lines, a quarter as bright as white on average.
    Caustics,
}

/// A generated texture that tiles.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Noise {
    pub generate: KindOfTexture,
    #[serde(default)]
    pub seed: u32,
    /// Edge \[texels\].
    #[serde(default = "edge")]
    pub size: u32,
    /// Cells of the coarsest octave along an edge.
    #[serde(default = "cells")]
    pub cells: u32,
    /// Velocity of the noise \[textures per second\].
    #[serde(default, deserialize_with = "array")]
    pub scroll: [f32; 2],
    /// Speed at which the noise evolves [1/s].
    #[serde(default)]
    pub evolve: f32,
}

fn edge() -> u32 {
    128
}
fn cells() -> u32 {
    4
}

const OCTAVES: u32 = 5;
/// Approximate standard deviation of the sum of octaves: spreads alpha over 0..1.
const SPREAD: f32 = 0.27;

/// An animated texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Animated {
    /// Index into [`Scene::textures`].
    pub texture: u32,
    pub noise: Noise,
}

impl Motion for Animated {
    fn apply(&self, scene: &mut Scene, seconds: f64) {
        let texture = &mut scene.textures[self.texture as usize];
        *texture = self.noise.texture(std::mem::take(&mut texture.name), seconds);
    }
}

impl Noise {
    pub const MAX_SIZE: u32 = 2048;
    pub const MAX_CELLS: u32 = 64;

    /// Whether it is animated.
    pub fn moves(&self) -> bool {
        self.scroll != [0.0; 2] || self.evolve != 0.0
    }

    /// The texture at `seconds` from the start.
    pub fn texture(&self, name: String, seconds: f64) -> Texture {
        let _phase = tracing::debug_span!("generate").entered();
        let shift =
            Vec2::from_array(self.scroll.map(|speed| (f64::from(speed) * seconds).fract() as f32));
        let age = (f64::from(self.evolve) * seconds).rem_euclid(65536.0) as f32;
        let cells = self.cells;
        let paint: Box<dyn Fn(Vec2) -> [u8; 4] + Sync> = match self.generate {
            KindOfTexture::Noise => {
                Box::new(|at| [255, 255, 255, (self.at(at, age) * 255.0).round() as u8])
            }
            KindOfTexture::Smoke => Box::new(move |at| {
                let alpha = self.at(at, age) * painted::window(at + shift);
                [255, 255, 255, (alpha * 255.0).round() as u8]
            }),
            KindOfTexture::Checks => Box::new(|at| painted::checks(at, cells)),
            KindOfTexture::Stripes => Box::new(|at| painted::stripes(at, cells)),
            KindOfTexture::Caustics => {
                let caustics = painted::Caustics::new(cells, self.seed, age);
                Box::new(move |at| caustics.at(at))
            }
        };
        let texel = |i: u32| {
            let middle = Vec2::new((i % self.size) as f32, (i / self.size) as f32) + 0.5;
            paint(middle / self.size as f32 - shift)
        };
        let texels: Vec<_> = (0..self.size * self.size).into_par_iter().map(texel).collect();
        Texture { name, width: self.size, height: self.size, rgba: texels.into_flattened() }
    }

    /// Alpha at `uv`, 0..=1; repeats at integers.
    fn at(&self, uv: Vec2, age: f32) -> f32 {
        let mut sum = 0.0;
        for octave in 0..OCTAVES {
            let cells = self.cells << octave;
            let seed = pcg(self.seed ^ octave << 24);
            sum += gradient_noise(uv * cells as f32, age * (octave + 1) as f32, cells, seed)
                / (1 << octave) as f32;
        }
        // A smoothstep from -2 to 2 deviations.
        let t = (0.5 + sum / (4.0 * SPREAD)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }
}

/// Gradient noise on a lattice that repeats after `cells`; gradients rotate with `age`.
fn gradient_noise(at: Vec2, age: f32, cells: u32, seed: u32) -> f32 {
    let low = at.floor();
    let part = at - low;
    let fade = part * part * part * (part * (part * 6.0 - 15.0) + 10.0);
    let corner = |x: i32, y: i32| {
        let cell = (low.as_ivec2() + IVec2::new(x, y)).rem_euclid(IVec2::splat(cells as i32));
        let hash = pcg(cell.x as u32 ^ pcg(cell.y as u32 ^ seed));
        let turns = (hash >> 8) as f32 / (1 << 24) as f32;
        // Neighbours rotate in opposite directions, so that the pattern as a whole does not rotate.
        let speed = if hash & 1 == 0 { age } else { -age };
        let gradient = Vec2::from_angle((turns + speed.fract()) * std::f32::consts::TAU);
        gradient.dot(part - Vec2::new(x as f32, y as f32))
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let top = mix(corner(0, 0), corner(1, 0), fade.x);
    let bottom = mix(corner(0, 1), corner(1, 1), fade.x);
    mix(top, bottom, fade.y)
}
