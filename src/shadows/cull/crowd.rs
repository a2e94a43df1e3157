//! How many casters may touch a tile at most.
use super::frustum::{rigid_axes, widened};
use crate::{
    model::{Bounds, TILE_SIZE},
    records::GpuView,
};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Cells in a row and column of the map, at most.
const CELLS: usize = 32;
/// What rectangles have to spare beyond what is in them [texels].
const SPARE: f64 = 2.0;

/// Counts by whole tiles of a view's map.
#[derive(Clone, Debug)]
pub struct Crowd {
    counts: [u32; CELLS * CELLS],
    /// `None` where the view cannot be judged.
    axes: Option<([DVec3; 3], DVec3)>,
    /// Of a cell [texels].
    edge: f64,
    /// [texels]
    middle: [f64; 2],
    scale: f64,
    perspective: bool,
}

impl Crowd {
    pub fn new(view: &GpuView) -> Self {
        let tiles = (view.size.max_element() as u32).div_ceil(TILE_SIZE);
        let edge = tiles.div_ceil(CELLS as u32).max(1) * TILE_SIZE;
        Self {
            counts: [0; CELLS * CELLS],
            axes: rigid_axes(view).filter(|_| view.scale > 0.0),
            edge: edge.into(),
            middle: (view.size.as_dvec2() * 0.5).to_array(),
            scale: view.scale.into(),
            perspective: view.perspective > 0.0,
        }
    }

    /// The casters of a box.
    pub fn add(&mut self, bounds: &Bounds, count: u32) {
        let [columns, rows] = self.cells(bounds);
        for row in rows {
            for cell in &mut self.counts[row * CELLS..][columns.clone()] {
                *cell = cell.saturating_add(count);
            }
        }
    }

    /// At most so many of what was added touch a tile that what is in the box touches too.
    pub fn most(&self, bounds: &Bounds) -> u32 {
        let [columns, rows] = self.cells(bounds);
        let counts = rows.flat_map(|row| &self.counts[row * CELLS..][columns.clone()]);
        counts.copied().max().unwrap_or(u32::MAX)
    }

    /// Columns and rows that the box may touch.
    fn cells(&self, bounds: &Bounds) -> [RangeInclusive<usize>; 2] {
        let all = [0..=CELLS - 1, 0..=CELLS - 1];
        let (Some((axes, shift)), Some(Bounds { min, max })) = (self.axes, widened(bounds)) else {
            return all;
        };
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let at = |i: usize| axes[i].dot(center) + shift[i];
        let reach = |i: usize| axes[i].abs().dot(half);
        let (mut nearest, mut farthest) = (-at(2) - reach(2), -at(2) + reach(2));
        // What is smaller than a texel is enlarged.
        let texel = if self.perspective { farthest } else { 1.0 } / self.scale;
        (nearest, farthest) =
            if self.perspective { (nearest - texel, farthest + texel) } else { (1.0, 1.0) };
        if nearest.is_nan() || nearest <= 0.0 {
            return all;
        }
        let side = |i: usize, sign: f64| {
            let (low, high) = (at(i) * sign - reach(i) - texel, at(i) * sign + reach(i) + texel);
            let low = low / if low < 0.0 { nearest } else { farthest };
            let high = high / if high < 0.0 { farthest } else { nearest };
            let cell = |slope: f64, spare: f64| {
                let texels = slope * self.scale + self.middle[i] + spare;
                // A NaN becomes 0, and so does what is before the first.
                ((texels / self.edge) as usize).min(CELLS - 1)
            };
            cell(low, -SPARE)..=cell(high, SPARE)
        };
        [side(0, 1.0), side(1, -1.0)]
    }
}
