//! Packing of numbers in records.
use glam::{Vec2, Vec3};
use half::f16;

/// Packs a channel of a colour, 0..=1: the root of 1 - c in 16 bits, so that a nearly white caster keeps its
/// absorption; for `gain`, the root of c, as a share of the largest. WGSL: `wgsl/records/pack.wgsl`.
pub(super) fn color_bits(c: f32, is_gain: bool) -> u32 {
    let c = c.clamp(0.0, 1.0);
    (0.5 + 65535.0 * if is_gain { c } else { 1.0 - c }.sqrt()) as u32
}

/// The inverse of [`color_bits`] for the low half.
pub(super) fn from_color_bits(bits: u32, is_gain: bool) -> f32 {
    let root = (bits & 0xffff) as f32 / 65535.0;
    if is_gain { root * root } else { 1.0 - root * root }
}

/// Scale of opacities, which are stored as halves: down to 2e-9 they have eleven bits. WGSL:
/// `OPACITY_SCALE` in `wgsl/records/record.wgsl`.
pub const OPACITY_SCALE: f32 = 32768.0;

/// Packs an opacity in 0..=1.
pub(super) fn opacity_bits(v: f32) -> u32 {
    u32::from(f16::from_f32(v * OPACITY_SCALE).to_bits())
}

pub(super) fn from_opacity(bits: u32) -> f32 {
    f16::from_bits(bits as u16).to_f32() / OPACITY_SCALE
}

/// Packs a unit vector in two snorm16 (Cigolle et al. 2014, section 3).
pub fn octahedral(n: Vec3) -> u32 {
    let n = n / (n.x.abs() + n.y.abs() + n.z.abs()).max(1e-20);
    let folded = if n.z < 0.0 {
        (Vec2::ONE - Vec2::new(n.y, n.x).abs()) * Vec2::new(1f32.copysign(n.x), 1f32.copysign(n.y))
    } else {
        Vec2::new(n.x, n.y)
    };
    let snorm = |v: f32| u32::from(((v.clamp(-1.0, 1.0) * 32767.0).round() as i16) as u16);
    snorm(folded.x) | snorm(folded.y) << 16
}

/// The inverse of [`octahedral`].
pub fn from_octahedral(bits: u32) -> Vec3 {
    let snorm = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
    let e = Vec2::new(snorm(bits), snorm(bits >> 16));
    let z = 1.0 - e.x.abs() - e.y.abs();
    let folded =
        (Vec2::ONE - Vec2::new(e.y, e.x).abs()) * Vec2::new(1f32.copysign(e.x), 1f32.copysign(e.y));
    let xy = if z < 0.0 { folded } else { e };
    xy.extend(z).normalize_or_zero()
}
