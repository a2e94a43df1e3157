//! Generated pictures for textures: test patterns of a projector, and caustics under water.
use crate::records::pcg;
use glam::{IVec2, Vec2, Vec3};

/// sRGB of linear light (IEC 61966-2-1).
fn srgb(light: Vec3) -> [u8; 4] {
    let encoded = light.to_array().map(|v| {
        let v = v.clamp(0.0, 1.0);
        let v = if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 };
        (v * 255.0).round() as u8
    });
    [encoded[0], encoded[1], encoded[2], 255]
}

/// A colour of the rainbow; `turn` repeats after 1.
fn rainbow(turn: f32) -> Vec3 {
    let channel = |shift: f32| {
        let t = (turn + shift).rem_euclid(1.0);
        (1.5 - (t - 0.5).abs() * 6.0 + 0.5).clamp(0.04, 1.0)
    };
    Vec3::new(channel(0.5), channel(0.5 - 1.0 / 3.0), channel(0.5 - 2.0 / 3.0))
}

/// A checkerboard with `cells` along an edge; an odd number repeats a colour across the texture's edge.
pub(super) fn checks(uv: Vec2, cells: u32) -> [u8; 4] {
    let cell = (uv * cells as f32).floor().as_ivec2().rem_euclid(IVec2::splat(cells as i32));
    if (cell.x + cell.y) % 2 == 0 {
        return [255; 4];
    }
    srgb(rainbow((cell.x + cell.y * 3) as f32 / (2 * cells) as f32))
}

pub(super) fn stripes(uv: Vec2, cells: u32) -> [u8; 4] {
    let cell = ((uv.x * cells as f32).floor() as i32).rem_euclid(cells as i32);
    srgb(rainbow(cell as f32 / cells as f32))
}

/// Bright lines along the borders of cells around wandering points (Worley 1996).
pub(super) fn caustics(uv: Vec2, cells: u32, seed: u32, age: f32) -> [u8; 4] {
    let fine = net(uv, 2 * cells, pcg(seed ^ 1), age * 1.3);
    let light = 0.7 * net(uv, cells, seed, age) + 0.3 * fine;
    srgb(Vec3::splat(light.min(1.0)))
}

/// Brightness of the lines: a quarter on average up to the rounding of `exp`; the constants are fitted.
fn net(uv: Vec2, cells: u32, seed: u32, age: f32) -> f32 {
    let at = uv * cells as f32;
    let low = at.floor().as_ivec2();
    let (mut first, mut second) = (f32::MAX, f32::MAX);
    for i in 0..9 {
        let cell = low + IVec2::new(i % 3 - 1, i / 3 - 1);
        let wrapped = cell.rem_euclid(IVec2::splat(cells as i32));
        let hash = pcg(wrapped.x as u32 ^ pcg(wrapped.y as u32 ^ seed));
        let turn = |bits: u32| (bits & 0xffff) as f32 / 65536.0;
        let speed = if hash & 1 == 0 { age } else { -age };
        let angle = Vec2::from_angle((turn(hash) + speed.fract()) * std::f32::consts::TAU);
        let point = cell.as_vec2() + 0.5 + angle * (0.15 + 0.3 * turn(hash >> 16));
        let distance = point.distance(at);
        (first, second) = (first.min(distance), second.min(distance.max(first)));
    }
    FLOOR + PEAK * (-SHARPNESS * (second - first)).exp()
}

/// Least brightness, peak at a border, and its falloff.
const FLOOR: f32 = 0.08;
const PEAK: f32 = 0.92;
const SHARPNESS: f32 = 10.8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caustics_are_a_quarter_on_average() {
        let mut sum = 0.0;
        for i in 0..128 * 128 {
            let uv = Vec2::new((i % 128) as f32 + 0.5, (i / 128) as f32 + 0.5) / 128.0;
            let light = 0.7 * net(uv, 6, 1, 0.3) + 0.3 * net(uv, 12, 7, 0.3);
            sum += light.min(1.0);
        }
        let mean = sum / (128.0 * 128.0);
        assert!((mean - 0.25).abs() < 0.01, "{mean}");
    }
}
