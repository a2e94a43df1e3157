//! Sums over the casters of a texel; sums of disjoint casters can be added. WGSL: `wgsl/sums/sums.wgsl`.

/// Optical depth 1 in fixed point.
pub const FIXED_ONE: f32 = 65536.0;
/// Largest addend of optical depth: past ln 1024 a texel is black.
pub const MAX_TAU: f32 = 7.0;
/// [`MAX_TAU`] in fixed point.
pub const SATURATED: u32 = 458_752;

/// Depths 0..=1 in an order in which 0 is no hit, and nearer depths are larger.
pub fn nearness(depth: f32) -> u32 {
    1.0_f32.to_bits() - depth.to_bits()
}

/// The sum over the casters of both, none with `gain`: the same in any order.
#[must_use]
pub fn added(sums: [u32; 4], others: [u32; 4]) -> [u32; 4] {
    let [tau @ .., nearest] = [0, 1, 2, 3].map(|i| (sums[i], others[i]));
    let [red, green, blue] = tau.map(|(a, b)| a.saturating_add(b).min(SATURATED));
    [red, green, blue, nearest.0.max(nearest.1)]
}

/// Transmittance per channel, and the nearest depth.
pub fn resolved(sums: [u32; 4]) -> ([f32; 3], f32) {
    let [red, green, blue, nearest] = sums;
    let light = [red, green, blue].map(|tau| (tau.cast_signed() as f32 / -FIXED_ONE).exp());
    (light, f32::from_bits(1.0_f32.to_bits() - nearest))
}
