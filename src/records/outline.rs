//! Outlines: the tiles that a Gaussian touches, row by row.
use bytemuck::{Pod, Zeroable};

/// Fractional bits of heights.
const HEIGHT_BITS: u32 = 24;
const MIDDLE_HEIGHT: i32 = 1 << HEIGHT_BITS;
/// Rounding of the stored and evaluated numbers, besides the slack of a texel \[units\].
pub const OUTLINE_ROUNDING: i32 = 4;

/// The outline of an ellipse in a view's tiles, in integers, so that all kernels that count, list or clip its
/// tiles decide with the same bits. At height `v` above its middle, as a share of its half height downwards,
/// the ellipse spans `middle + lean v - width sqrt(1 - v^2)` to `middle + lean v + width sqrt(1 - v^2)`. A
/// unit is a tile's edge halved `shift` times. WGSL: `wgsl/records/outline.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Outline {
    /// Height of the first texels of row `row` [2^-24], less its rounding.
    pub first: i32,
    /// Height of a tile [2^-24], 27 bits, and `shift`.
    pub step_shift: u32,
    /// `lean`, signed, and `width` \[units\], 16 bits each.
    pub lean_width: u32,
    /// `row` \[tiles\], 8 bits, and `middle`, signed \[units\].
    pub row_middle: u32,
}

impl Outline {
    /// First column of tiles that the ellipse touches in a row, and the column behind its last, within a
    /// rectangle; an empty range for none.
    pub fn columns(&self, row: u32, rect: std::ops::RangeInclusive<u32>) -> std::ops::Range<u32> {
        let step = (self.step_shift & 0x7ff_ffff) as i32;
        let shift = self.step_shift >> 27;
        let lean = i32::from(self.lean_width as i16);
        let width = (self.lean_width >> 16) as i32;
        let below = row.wrapping_sub(self.row_middle & 255) as i32;
        let high = self.first.wrapping_add(below.wrapping_mul(step));
        // The texel centres of a tile span 15/16 of it, with slack of a 64th of a texel on both sides.
        let low = high.wrapping_add(step - (step >> 4) + (step >> 9)).wrapping_add(512);
        let half = (lean * lean + width * width).cast_unsigned().isqrt().max(1).cast_signed();
        let farthest = ((lean << 15) / half) << (HEIGHT_BITS - 15);
        let at = |height: i32| {
            let height = height.max(high).min(low).clamp(-MIDDLE_HEIGHT, MIDDLE_HEIGHT);
            let height = height >> (HEIGHT_BITS - 15);
            let inner = (height.abs() - 1).max(0);
            let across = ((1 << 30) - inner * inner).cast_unsigned().isqrt().cast_signed() + 1;
            [(lean * height) >> 15, (width * across) >> 15]
        };
        let ([left, left_half], [right, right_half]) = (at(-farthest), at(farthest));
        let middle = self.row_middle.cast_signed() >> 8;
        let unit = 1_i32 << shift;
        let inset = (unit >> 5) - (unit >> 10) - OUTLINE_ROUNDING;
        let first = (middle + left - left_half + inset - 1) >> shift;
        let last = (middle + right + right_half - inset) >> shift;
        let first = first.max(*rect.start() as i32);
        let end = last.min(*rect.end() as i32) + 1;
        first as u32..end.max(first) as u32
    }
}
