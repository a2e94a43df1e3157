//! Footprints: casters projected to one view.
use super::{
    Outline,
    pack::{color_bits, from_color_bits, from_opacity, opacity_bits},
};
use crate::model::Transfer;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// Texels of a [`Footprint`].
pub const FOOTPRINT_TEXELS: u32 = 2;
/// Bit of [`Footprint::caster`] that marks a triangle.
pub const TRIANGLE_BIT: u32 = 1 << 31;
/// [`Footprint::thin`] of a Gaussian, which no particle has.
pub const GAUSSIAN_MARK: u32 = 0xffff;
/// The same for a capsule.
pub const CAPSULE_MARK: u32 = 0xfffe;
/// Projected radius below which a particle is enlarged and thinned: half the diagonal of a texel, so that
/// one texel's centre is always hit \[texels\].
pub const MIN_RADIUS: f32 = std::f32::consts::FRAC_1_SQRT_2;
/// Bits of the depth key. For commutative transfers the order only serves early termination.
pub const DEPTH_BITS: u32 = 16;
/// Key of a caster that touches no texel: sorts behind all others.
pub const INVISIBLE: u32 = (1 << DEPTH_BITS) - 1;

/// Pairs of a segment in curve mode. Longer than in nearest-depth mode, because each segment stores a whole
/// curve; seven loop iterations a pair stay below the 65,535 of llvmpipe.
pub const CURVE_SEGMENT: u32 = 8192;
/// The same with `over` or volumes, whose ramps are inserted between hits: thirteen iterations a pair.
pub const ORDERED_SEGMENT: u32 = 4096;
/// The same with bricks, each of which makes several hits: a hundred iterations a brick.
pub const BRICK_SEGMENT: u32 = 512;

/// A caster projected to one view.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Footprint {
    /// Centre in the view's map \[texels\]; for a triangle, of its bounding square; for a particle beside the
    /// view ([`Self::beside`]), its offset to the right and down \[m\].
    pub center: Vec2,
    /// Orthographic: radius \[texels\]. Perspective: radius over distance from the light. Triangle: half the
    /// side of the bounding square \[texels\]. Negative for a particle without a centre in the map
    /// ([`Self::beside`]): minus its radius \[m\]. Gaussian: distance at which it ends, in standard
    /// deviations; negative if it is beside the view. Capsule: reach from its axis \[texels\]; negative if an
    /// end is beside the view.
    pub radius: f32,
    /// Light depth of the centre; for a triangle, the smallest; for a particle without a centre in the map,
    /// its distance along the axis \[m\].
    pub depth: f32,
    /// Colour times tint, red and green, the roots of 1 - c in 16 bits; divided by 16 for a `gain` material.
    /// Capsule: half of its axis, to the right, as bits \[texels\]; `blue_slope` holds it downwards.
    pub red_green: u32,
    /// Blue, the roots of 1 - c in 16 bits, and the slope of the thinned opacity, f16.
    pub blue_slope: u32,
    /// Ratio of its area to its projected area, which is no smaller than a texel: f16 in the low half.
    pub thin: u32,
    /// Index of the particle, or of the triangle with [`TRIANGLE_BIT`].
    pub caster: u32,
}

impl Footprint {
    /// `transfer`: the material's.
    pub fn set_opacity(&mut self, color: Vec3, transfer: u32, thin: f32, slope: f32) {
        let is_gain = transfer == Transfer::Gain as u32;
        self.red_green = color_bits(color.x, is_gain) | color_bits(color.y, is_gain) << 16;
        self.blue_slope = color_bits(color.z, is_gain) | opacity_bits(slope) << 16;
        self.thin = opacity_bits(thin);
    }

    /// View-space centre of a particle whose centre has no position in the map: to the right, down and
    /// along the axis \[m\]. `None` for all others. WGSL: `is_beside` in `wgsl/records/view.wgsl`.
    pub fn beside(&self) -> Option<Vec3> {
        (self.radius < 0.0).then(|| self.center.extend(self.depth))
    }

    /// Colour `c`, rgb; divided by 16 for a `gain` material. `transfer`: the material's.
    pub fn color(&self, transfer: u32) -> Vec3 {
        let is_gain = transfer == Transfer::Gain as u32;
        Vec3::new(
            from_color_bits(self.red_green, is_gain),
            from_color_bits(self.red_green >> 16, is_gain),
            from_color_bits(self.blue_slope, is_gain),
        )
    }

    /// Ratio of the areas, 1 for a particle that is not enlarged.
    pub fn thin(&self) -> f32 {
        from_opacity(self.thin)
    }

    /// Slope of the thinned opacity `a = reflectivity * thin + slope * texture.a * profile`.
    pub fn slope(&self) -> f32 {
        from_opacity(self.blue_slope >> 16)
    }
}

/// Tiles of a footprint: `project` decides them once, `bin` reads them twice.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct TileRect {
    /// First and last column and row, inclusive, 8 bits each: x0, y0, x1, y1.
    pub corners: u32,
    /// Low half: for a rectangle of at most 4x4, a mask of the touched tiles, row by row, 4 bits a row; for a
    /// larger one [`TileRect::WHOLE`], or the number of tiles that its outline touches; 0 for none. High
    /// half: the view's index in its batch.
    pub mask_view: u32,
}

impl TileRect {
    /// No tiles.
    pub const EMPTY: Self = Self { corners: 0, mask_view: 0 };
    /// Mask of a rectangle larger than 4x4 whose tiles are all touched.
    pub const WHOLE: u32 = 0xffff;

    /// Mark of a caster on the scatter path: no tiles, and corners that no rectangle without tiles has.
    pub fn scattered(view: u32) -> Self {
        Self { corners: u32::MAX, mask_view: view << 16 }
    }

    /// Whether the caster is scattered, not binned.
    pub fn is_scattered(&self) -> bool {
        self.corners == u32::MAX && self.mask_view & 0xffff == 0
    }

    /// Columns of tiles, both ends inside.
    pub fn x(&self) -> std::ops::RangeInclusive<u32> {
        (self.corners & 255)..=(self.corners >> 16 & 255)
    }

    /// Rows of tiles, both ends inside.
    pub fn y(&self) -> std::ops::RangeInclusive<u32> {
        (self.corners >> 8 & 255)..=(self.corners >> 24)
    }

    /// Index of the view.
    pub fn view(&self) -> u32 {
        self.mask_view >> 16
    }

    /// Whether it has at most 4 x 4 tiles, and so a mask.
    fn is_small(&self) -> bool {
        self.x().end() - self.x().start() < 4 && self.y().end() - self.y().start() < 4
    }

    /// Tiles `(x, y)` in row order. `outline`: the footprint's, if it is a Gaussian's.
    pub fn tiles(&self, outline: Option<&Outline>) -> impl Iterator<Item = (u32, u32)> {
        let (xs, ys, mask) = (self.x(), self.y(), self.mask_view & 0xffff);
        let (x0, y0, is_small) = (*xs.start(), *ys.start(), self.is_small());
        let outline = outline.copied().filter(|_| !is_small && mask != Self::WHOLE);
        ys.flat_map(move |y| {
            let whole = *xs.start()..xs.end() + 1;
            let columns = outline.map_or(whole, |outline| outline.columns(y, xs.clone()));
            columns.map(move |x| (x, y))
        })
        .filter(move |&(x, y)| mask != 0 && (!is_small || mask >> ((y - y0) * 4 + x - x0) & 1 == 1))
    }
}
