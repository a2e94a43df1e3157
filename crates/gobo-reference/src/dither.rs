//! Dither patterns: the threshold that a caster's opacity must exceed at a texel to block its light.
//!
//! The share of texels that block equals the opacity itself, not its nearest level: below the finest level of
//! a pattern a random number per block decides. Patterns of different casters are independent: two layers of
//! 50% let 25% through. Ranks and thresholds are integers, so that all devices agree. WGSL:
//! `wgsl/hit/dither.wgsl`.
use glam::{IVec2, UVec2, Vec2};
use gobo::{
    model::Pattern,
    records::{BLUE_SIZE, GpuView, blue_ranks, pcg},
};

/// Base-2 logarithm of the edge of blocks \[cells\]: casters with the same lowest id bits have new patterns
/// in each.
pub const BLOCK_BITS: u32 = 4;

/// Position at which a caster's threshold is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatternPoint {
    /// Cell of the pattern, in light space.
    pub cell: UVec2,
    /// Coordinates in the caster's own space, without unit.
    pub on_caster: Vec2,
    /// Change of `on_caster` per texel, along each axis.
    pub step: Vec2,
}

/// Largest distance from the world's origin at which a pattern is anchored \[texels\].
pub const FARTHEST: f32 = 524_288.0;

/// The pattern's cell at a texel of a view's map. For a parallel light the pattern stays fixed in the world
/// when the view moves by whole texels.
pub fn cell(view: &GpuView, scale: u32, texel: Vec2) -> UVec2 {
    let origin = view.view_from_world.w_axis * view.scale;
    let anchor =
        Vec2::new(origin.x, -origin.y).clamp(Vec2::splat(-FARTHEST), Vec2::splat(FARTHEST));
    let anchor = if view.perspective > 0.0 {
        IVec2::ZERO
    } else {
        IVec2::new(anchor.x.round_ties_even() as i32, anchor.y.round_ties_even() as i32)
    };
    // A multiple of every pattern's period that makes the sum positive.
    let ahead = IVec2::splat((scale << 20) as i32);
    (texel.floor().as_ivec2() - anchor + ahead).as_uvec2() / scale
}

fn pcg_cell(cell: UVec2, id: u32) -> u32 {
    pcg(cell.x.wrapping_add(pcg(cell.y.wrapping_add(pcg(id)))))
}

/// Dither threshold, 0..1: an opacity above it blocks the light.
pub fn threshold(pattern: Pattern, scale: u32, point: &PatternPoint, id: u32) -> f32 {
    let bits = match pattern {
        Pattern::Hashed => return hashed(point, scale, id),
        Pattern::Ign => gradient_noise(point.cell, id),
        Pattern::Blue => blue(point.cell, id),
        Pattern::Checkerboard => ordered(point.cell, 2, id, pcg(id)),
        _ => {
            let order = pattern.order();
            ordered(point.cell, order, id, pcg_cell(point.cell >> order, id))
        }
    };
    bits as f32 / 65536.0
}

/// Interleaves the three bits above the lowest `shift` of both coordinates.
fn interleaved(cell: UVec2, shift: u32) -> u32 {
    let h = cell >> shift;
    (0..3).fold(0, |word, i| word | (h.x >> i & 1) << (2 * i) | (h.y >> i & 1) << (2 * i + 1))
}

fn parity(word: u32) -> u32 {
    word.count_ones() & 1
}

/// A recursive ordered matrix of edge `2^order` whose digits are flipped by Walsh functions of the cell: one
/// function per caster; different ones are independent over 16x16 cells. Functions of a caster's further
/// digits are multiples in GF(64), so all digits of two casters are independent.
fn ordered(cell: UVec2, order: u32, id: u32, chance: u32) -> u32 {
    let mut walsh = id & 63;
    let mut next = || {
        let mask = walsh;
        walsh = (walsh << 1 & 63) ^ ((walsh >> 5) * 3);
        mask
    };
    let mut rank = 0;
    for digit in 0..order {
        let (x, y) = (cell.x >> digit & 1, cell.y >> digit & 1);
        let higher = interleaved(cell, digit + 1);
        let high = x ^ y ^ parity(higher & next());
        let low = y ^ parity(higher & next());
        rank = rank << 2 | high << 1 | low;
    }
    let levels = 1 << (2 * order);
    // Distinguishes casters with the same Walsh function.
    if id >= 64 {
        rank ^= pcg_cell(cell >> BLOCK_BITS, id >> 6) & (levels - 1);
    }
    (rank << 16 | chance >> 16) / levels
}

/// Interleaved gradient noise. Unlike the paper: in fixed point; and rotated, sheared and shifted by caster
/// and block, because shifted noise is only itself plus a constant.
fn gradient_noise(cell: UVec2, id: u32) -> u32 {
    let turn = pcg(id);
    let shift = pcg_cell(cell >> BLOCK_BITS, id);
    let mut at = turned(cell, turn);
    at.x = at.x.wrapping_add(at.y.wrapping_mul(turn >> 1 & 2));
    let x = at.x.wrapping_add(shift & 0xffff);
    let y = at.y.wrapping_add(shift >> 16);
    // The constants 0.06711056, 0.00583715 and 52.9829189 in fixed point.
    let inner = x.wrapping_mul(288_237_660).wrapping_add(y.wrapping_mul(25_070_368));
    inner.wrapping_mul(52).wrapping_add((inner >> 16) * 64_417) >> 16
}

/// One of four reflections of the cell.
fn turned(cell: UVec2, turn: u32) -> UVec2 {
    let at = if turn & 1 == 0 { cell } else { UVec2::new(cell.y, cell.x) };
    UVec2::new(if turn & 2 == 0 { at.x } else { !at.x }, at.y)
}

fn blue(cell: UVec2, id: u32) -> u32 {
    // By the golden ratio: consecutive casters have distant offsets in the texture.
    let offset = id.wrapping_mul(2_654_435_769) >> 20;
    let at = turned(cell, pcg(id));
    let x = at.x.wrapping_add(offset) % BLUE_SIZE;
    let y = at.y.wrapping_add(offset >> 6) % BLUE_SIZE;
    u32::from(blue_ranks()[(y * BLUE_SIZE + x) as usize]) << 4 | 8
}

/// Hashed threshold. Unlike the paper: base-2 logarithms are those of the float's bits, and the ratio of the
/// axes' scales is a power of two, so that the pattern never jumps as the light comes nearer.
fn hashed(point: &PatternPoint, scale: u32, id: u32) -> f32 {
    let step = (point.step * scale as f32).max(Vec2::splat(1e-9));
    let per_unit = std::f32::consts::FRAC_1_SQRT_2 / step.x;
    let between = f32::from_bits(per_unit.to_bits() & 0x007f_ffff | 0x3f80_0000) - 1.0;
    let exponent = |v: f32| (v.to_bits() >> 23 & 255) as i32 - 127;
    let x = exponent(per_unit).clamp(-20, 20);
    let y = (x + exponent(step.x / step.y * std::f32::consts::SQRT_2)).clamp(-24, 24);
    let coarse = caster_hash(point.on_caster, x, y, id);
    let fine = caster_hash(point.on_caster, x + 1, y + 1, id);
    uniform(coarse * (1.0 - between) + fine * between, between.min(1.0 - between))
}

fn caster_hash(on_caster: Vec2, x: i32, y: i32, id: u32) -> f32 {
    let power = |e: i32| f32::from_bits(((e + 127) as u32) << 23);
    let cell =
        Vec2::new(on_caster.x * power(x), on_caster.y * power(y)).floor().as_ivec2().as_uvec2();
    ((pcg_cell(cell, id ^ ((x + 127) as u32) << 24) >> 16) as f32 + 0.5) / 65536.0
}

/// Cumulative distribution of a mix of two uniform numbers; `a`: the smaller weight (section 3.2).
fn uniform(x: f32, a: f32) -> f32 {
    let b = 1.0 - a;
    let tails = 2.0 * (a * b).max(1e-6);
    let share = if x < a {
        x * x / tails
    } else if x < b {
        (x - 0.5 * a) / b
    } else {
        1.0 - (1.0 - x) * (1.0 - x) / tails
    };
    share.clamp(0.0, 65535.0 / 65536.0)
}
