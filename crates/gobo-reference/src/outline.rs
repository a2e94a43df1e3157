//! CPU reference of `wgsl/project/conic.wgsl` and of `outlined_tiles` in `wgsl/records/outline.wgsl`.
use super::project::{SLACK, TexelBox};
use glam::Vec2;
use gobo::{
    model::TILE_SIZE,
    records::{Outline, TileRect},
};

/// Factor by which ellipses are enlarged, against the rounding of their form.
pub const OUTLINE_GROWTH: f32 = 1.0002;
/// Largest half width \[units\].
pub const WIDEST_OUTLINE: f32 = 32000.0;
/// Base-2 logarithms of the units' edges \[texels\].
pub const FINEST_UNIT: i32 = -8;
/// Logarithm to base 2 of the largest edge of a unit \[texels\].
pub const COARSEST_UNIT: i32 = 4;
/// Least openness of an ellipse: closer to the eye's plane it is known too roughly. 1 is far away.
pub const LEAST_OPEN: f32 = 1e-3;

/// Texels at `middle + (lean v -+ width sqrt(1 - v^2), half.y v)`.
#[derive(Clone, Copy, Debug)]
pub struct Ellipse {
    /// Centre, and half width and height \[texels\].
    pub middle: Vec2,
    /// Half of its extent along x and y \[texels\].
    pub half: Vec2,
    /// How far a row's middle moves along x to the top \[texels\].
    pub lean: f32,
    /// Half of its width in the row of the middle \[texels\].
    pub width: f32,
    /// Openness: how far the Gaussian is from the eye's plane; 1 is far away.
    pub open: f32,
}

impl Ellipse {
    pub(super) fn bounds(&self) -> TexelBox {
        TexelBox { min: self.middle - self.half, max: self.middle + self.half }
    }
}

/// Base-2 logarithm of the edge of the smallest unit in which half the width is within [`WIDEST_OUTLINE`]
/// \[texels\].
fn unit_log(ellipse: &Ellipse) -> i32 {
    let edge = (ellipse.half.x * (OUTLINE_GROWTH / WIDEST_OUTLINE)).to_bits();
    ((edge >> 23) as i32 - 126).max(FINEST_UNIT)
}

/// The outline from row `row` of tiles on; `None` if all tiles of its rectangle count as touched.
pub fn outline_of(ellipse: &Ellipse, row: u32) -> Option<Outline> {
    let log = unit_log(ellipse);
    if !(ellipse.open >= LEAST_OPEN && log <= COARSEST_UNIT) {
        return None;
    }
    let per_texel = f32::from_bits(((127 - log) as u32) << 23);
    let high = ellipse.half.y * OUTLINE_GROWTH;
    let top = (row * TILE_SIZE) as f32 + 0.5 - SLACK;
    let first = ((top - ellipse.middle.y) / high * 16_777_216.0).floor() as i32 - 256;
    let step = (TILE_SIZE as f32 / high * 16_777_216.0).ceil() as u32;
    let lean = (ellipse.lean * OUTLINE_GROWTH * per_texel).round_ties_even() as i32;
    let width = (ellipse.width * OUTLINE_GROWTH * per_texel).ceil() as u32;
    let middle = (ellipse.middle.x * per_texel).round_ties_even() as i32;
    Some(Outline {
        first,
        step_shift: step | ((COARSEST_UNIT - log) as u32) << 27,
        lean_width: lean as u32 & 0xffff | width << 16,
        row_middle: row | (middle as u32) << 8,
    })
}

/// The tiles of a rectangle within an outline, without rows that have none.
pub fn outlined_tiles(outline: &Outline, rect: TileRect) -> TileRect {
    let left = *rect.x().start();
    let (mut top, mut bottom, mut count, mut mask) = (255, 0, 0, 0);
    for row in rect.y() {
        let columns = outline.columns(row, rect.x());
        if columns.is_empty() {
            continue;
        }
        top = top.min(row);
        bottom = row;
        count += columns.len() as u32;
        if row - top < 4 {
            let bits = ((1 << columns.len().min(4)) - 1) << (columns.start - left).min(4);
            mask |= (bits & 15) << (4 * (row - top));
        }
    }
    if count == 0 {
        return TileRect::EMPTY;
    }
    let is_small = *rect.x().end() < left + 4 && bottom - top < 4;
    TileRect {
        corners: rect.corners & 0x00ff_00ff | top << 8 | bottom << 24,
        mask_view: rect.mask_view & 0xffff_0000
            | if is_small { mask } else { count.min(TileRect::WHOLE) },
    }
}
