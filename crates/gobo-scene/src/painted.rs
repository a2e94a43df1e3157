//! Generated images for textures: a projector's test patterns, and underwater caustics.
use glam::{IVec2, Vec2};
use gobo::records::pcg;

/// sRGB encoding of linear light (IEC 61966-2-1).
fn srgb(light: f32) -> u8 {
    let v = light.clamp(0.0, 1.0);
    let v = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
    (v * 255.0).round() as u8
}

/// A rainbow colour, with period 1 in `turn`.
fn rainbow(turn: f32) -> [u8; 4] {
    let channel = |shift: f32| {
        let t = (turn + shift).rem_euclid(1.0);
        srgb((1.5 - (t - 0.5).abs() * 6.0 + 0.5).clamp(0.04, 1.0))
    };
    [channel(0.5), channel(0.5 - 1.0 / 3.0), channel(0.5 - 2.0 / 3.0), 255]
}

/// A checkerboard with `cells` along an edge; an odd number repeats a colour across the texture's edge.
pub(super) fn checks(uv: Vec2, cells: u32) -> [u8; 4] {
    let cell = (uv * cells as f32).floor().as_ivec2().rem_euclid(IVec2::splat(cells as i32));
    if (cell.x + cell.y) % 2 == 0 {
        return [255; 4];
    }
    rainbow((cell.x + cell.y * 3) as f32 / (2 * cells) as f32)
}

pub(super) fn stripes(uv: Vec2, cells: u32) -> [u8; 4] {
    let cell = ((uv.x * cells as f32).floor() as i32).rem_euclid(cells as i32);
    rainbow(cell as f32 / cells as f32)
}

/// A round window: 1 in the middle of the texture, 0 from the middle of its edges on.
pub(super) fn window(uv: Vec2) -> f32 {
    let t = ((1.0 - (2.0 * uv - 1.0).length()) / SOFT_RIM).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Width of a window's rim, in half edges of the texture.
const SOFT_RIM: f32 = 0.7;

/// Bright lines along the borders of the Voronoi cells of wandering points (Worley 1996).
pub(super) struct Caustics {
    coarse: Net,
    fine: Net,
}

impl Caustics {
    pub(super) fn new(cells: u32, seed: u32, age: f32) -> Self {
        Self {
            coarse: Net::new(cells, seed, age),
            fine: Net::new(2 * cells, pcg(seed ^ 1), age * 1.3),
        }
    }

    pub(super) fn at(&self, uv: Vec2) -> [u8; 4] {
        let grey = srgb(self.light(uv));
        [grey, grey, grey, 255]
    }

    fn light(&self, uv: Vec2) -> f32 {
        (0.7 * self.coarse.at(uv) + 0.3 * self.fine.at(uv)).min(1.0)
    }
}

/// Lines between the points of a tiling lattice of cells.
struct Net {
    cells: u32,
    /// Position of each cell's point relative to its middle, row by row \[cells\].
    points: Vec<Vec2>,
}

impl Net {
    fn new(cells: u32, seed: u32, age: f32) -> Self {
        let point = |cell: u32| {
            let hash = pcg((cell % cells) ^ pcg((cell / cells) ^ seed));
            let turn = |bits: u32| (bits & 0xffff) as f32 / 65536.0;
            let speed = if hash & 1 == 0 { age } else { -age };
            let angle = Vec2::from_angle((turn(hash) + speed.fract()) * std::f32::consts::TAU);
            angle * (0.15 + 0.3 * turn(hash >> 16))
        };
        Self { cells, points: (0..cells * cells).map(point).collect() }
    }

    /// Brightness of the lines: a quarter on average up to the rounding of `exp`; the constants are fitted.
    fn at(&self, uv: Vec2) -> f32 {
        let at = uv * self.cells as f32;
        let low = at.floor().as_ivec2();
        // Squares of the two smallest distances.
        let (mut first, mut second) = (f32::MAX, f32::MAX);
        for y in low.y - 1..=low.y + 1 {
            let row = y.rem_euclid(self.cells as i32) as usize * self.cells as usize;
            for x in low.x - 1..=low.x + 1 {
                let point = self.points[row + x.rem_euclid(self.cells as i32) as usize];
                let distance = (IVec2::new(x, y).as_vec2() + 0.5 + point).distance_squared(at);
                (first, second) = (first.min(distance), second.min(distance.max(first)));
            }
        }
        FLOOR + PEAK * (-SHARPNESS * (second.sqrt() - first.sqrt())).exp()
    }
}

/// Minimum brightness, peak at a border, and its falloff.
const FLOOR: f32 = 0.08;
const PEAK: f32 = 0.92;
const SHARPNESS: f32 = 10.8;

#[cfg(test)]
mod tests {
    use super::*;

    /// A smoothstep over the rim: a half at its middle, nothing along the texture's edges.
    #[test]
    fn a_window_is_round() {
        let off = |x: f32, y: f32| window(Vec2::new(0.5 + 0.5 * x, 0.5 + 0.5 * y));
        assert!(off(0.0, 0.0) == 1.0 && off(0.2, -0.2) == 1.0);
        for angle in 0..16 {
            let way = Vec2::from_angle(angle as f32 * 0.4);
            let half = off(0.65 * way.x, 0.65 * way.y);
            assert!((half - 0.5).abs() < 1e-5 && off(way.x, way.y) < 1e-9, "{half}");
        }
        assert_eq!(off(1.0, 1.0), 0.0);
    }

    #[test]
    fn caustics_are_a_quarter_on_average() {
        let caustics = Caustics { coarse: Net::new(6, 1, 0.3), fine: Net::new(12, 7, 0.3) };
        let mut sum = 0.0;
        for i in 0..128 * 128 {
            let uv = Vec2::new((i % 128) as f32 + 0.5, (i / 128) as f32 + 0.5) / 128.0;
            sum += caustics.light(uv);
        }
        let mean = sum / (128.0 * 128.0);
        assert!((mean - 0.25).abs() < 0.01, "{mean}");
    }
}
