//! Bounds of the casters per tile and of the pairs of a list.
use super::frustum::{rigid_axes, widened};
use crate::{
    model::{Bounds, TILE_SIZE},
    records::GpuView,
};
use glam::DVec3;
use std::ops::RangeInclusive;

/// Upper bounds for a list. `Default`: an empty list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PairBound {
    /// Pairs of the list.
    pub pairs: u64,
    /// Casters that touch one tile.
    pub of_tile: u32,
    /// Tiles that one caster touches.
    pub of_caster: u32,
}

impl PairBound {
    /// Bound over all views of a batch, whose tiles are disjoint.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            pairs: self.pairs.saturating_add(other.pairs),
            of_tile: self.of_tile.max(other.of_tile),
            of_caster: self.of_caster.max(other.of_caster),
        }
    }
}

/// Halves of the longest sides of boxes around single casters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CasterReach {
    /// \[m\]
    pub most: f32,
    /// Sum over the casters \[m\].
    pub sum: f64,
    /// \[m²\]
    pub sum_of_squares: f64,
}

impl CasterReach {
    /// `count` casters that reach at most `most` \[m\].
    pub fn all(most: f32, count: u32) -> Self {
        let (reach, count) = (f64::from(most), f64::from(count));
        Self { most, sum: count * reach, sum_of_squares: count * reach * reach }
    }

    /// Adds a caster's reach \[m\].
    pub fn add(&mut self, reach: f32) {
        self.most = self.most.max(reach);
        self.sum += f64::from(reach);
        self.sum_of_squares += f64::from(reach) * f64::from(reach);
    }
}

/// Most cells per row and column of the map.
const CELLS: usize = 32;
/// Margin of rectangles beyond their contents \[texels\].
const SPARE: f64 = 2.0;

/// Grid of caster counts over whole tiles of a view's map, and the pairs.
#[derive(Clone, Debug)]
pub struct TileLoadBound {
    counts: [u32; CELLS * CELLS],
    pairs: u64,
    of_caster: u32,
    /// Columns and rows of tiles.
    tiles: [u32; 2],
    /// View axes; `None` if they are not orthonormal.
    axes: Option<([DVec3; 3], DVec3)>,
    /// Edge of a cell \[texels\].
    edge: f64,
    /// Centre of the map \[texels\].
    middle: [f64; 2],
    scale: f64,
    perspective: bool,
}

impl TileLoadBound {
    /// No load on the tiles of a view.
    pub fn new(view: &GpuView) -> Self {
        let tiles = (view.size.max_element() as u32).div_ceil(TILE_SIZE);
        let edge = tiles.div_ceil(CELLS as u32).max(1) * TILE_SIZE;
        Self {
            counts: [0; CELLS * CELLS],
            pairs: 0,
            of_caster: 0,
            tiles: view.size.to_array().map(|side| (side as u32).div_ceil(TILE_SIZE)),
            axes: rigid_axes(view).filter(|_| view.scale > 0.0),
            edge: edge.into(),
            middle: (view.size.as_dvec2() * 0.5).to_array(),
            scale: view.scale.into(),
            perspective: view.perspective > 0.0,
        }
    }

    /// Adds the casters of a box. `enlarged`: largest reach beyond the boxes around them \[texels\].
    pub fn add(&mut self, bounds: &Bounds, count: u32, reach: CasterReach, enlarged: f32) {
        let touched = self.touched(bounds, enlarged.into());
        let [columns, rows] = self.cells(touched.as_ref());
        for row in rows {
            for cell in &mut self.counts[row * CELLS..][columns.clone()] {
                *cell = cell.saturating_add(count);
            }
        }
        let of_one = self.tiles_of_one(touched.as_ref(), reach.most.into());
        self.of_caster = self.of_caster.max(of_one);
        let by_largest = u64::from(of_one) * u64::from(count);
        let by_sums = touched.map_or(u64::MAX, |touched| self.tiles_of_all(&touched, count, reach));
        self.pairs = self.pairs.saturating_add(by_largest.min(by_sums));
    }

    /// Most casters added so far that touch one tile together with the box.
    pub fn most(&self, bounds: &Bounds) -> u32 {
        let [columns, rows] = self.cells(self.touched(bounds, 1.0).as_ref());
        let counts = rows.flat_map(|row| &self.counts[row * CELLS..][columns.clone()]);
        counts.copied().max().unwrap_or(u32::MAX)
    }

    /// Bound of everything added.
    pub fn bound(&self) -> PairBound {
        let of_tile = self.counts.iter().copied().max().unwrap_or(u32::MAX);
        PairBound { pairs: self.pairs, of_tile, of_caster: self.of_caster }
    }

    /// Largest number of tiles that a caster of half-side `reach` within `touched` touches.
    fn tiles_of_one(&self, touched: Option<&Touched>, reach: f64) -> u32 {
        let all = self.tiles[0] * self.tiles[1];
        let Some(touched) = touched else { return all };
        let sides = [0, 1].map(|i| {
            let [low, high] = touched.sides[i];
            let tile = |texels: f64| (texels / f64::from(TILE_SIZE)) as u32;
            let last = self.tiles[i] - 1;
            // Between the first and the last tile that the box touches.
            let within = tile(high).min(last) - tile(low).min(last) + 1;
            // A box of side 2 r whose near side is at the depth n, its middle x beside the axis:
            // its slopes are at most 2 r (n + r + x) / (n (n + 2 r)) apart.
            let r = reach + touched.texel;
            let n = touched.nearest;
            let slopes = if self.perspective {
                2.0 * r * (n + r + touched.beside[i]) / (n * (n + 2.0 * r))
            } else {
                2.0 * r
            };
            // A NaN gives the most tiles.
            let wide = (slopes * self.scale + 2.0 * SPARE) / f64::from(TILE_SIZE);
            let wide = if wide < f64::from(self.tiles[i]) { wide as u32 + 2 } else { u32::MAX };
            wide.min(within)
        });
        sides[0] * sides[1]
    }

    /// Largest number of pairs of casters within `touched`: the sides of [`Self::tiles_of_one`] are at most
    /// linear in the reach.
    fn tiles_of_all(&self, touched: &Touched, count: u32, reach: CasterReach) -> u64 {
        let per_tile = 2.0 * self.scale / f64::from(TILE_SIZE);
        let [[a, b], [c, d]] = touched.beside.map(|beside| {
            let n = touched.nearest;
            let slope = if self.perspective { (1.0 + beside / n) / n } else { 1.0 };
            let per_metre = per_tile * slope;
            [per_metre, per_metre * touched.texel + 2.0 * SPARE / f64::from(TILE_SIZE) + 2.0]
        });
        let [squares, sums] = [a * c * reach.sum_of_squares, (a * d + b * c) * reach.sum];
        let tiles = squares + sums + f64::from(count) * b * d;
        if tiles.is_nan() { u64::MAX } else { tiles.ceil() as u64 }
    }

    /// Columns and rows of cells that the box may touch.
    fn cells(&self, touched: Option<&Touched>) -> [RangeInclusive<usize>; 2] {
        let Some(touched) = touched else { return [0..=CELLS - 1, 0..=CELLS - 1] };
        touched.sides.map(|[low, high]| {
            // A NaN becomes 0, and so does a position before the first cell.
            let cell = |texels: f64| ((texels / self.edge) as usize).min(CELLS - 1);
            cell(low)..=cell(high)
        })
    }

    /// Part of the map that the box may touch; `None` if unknown.
    fn touched(&self, bounds: &Bounds, enlarged: f64) -> Option<Touched> {
        let (axes, shift) = self.axes?;
        let Bounds { min, max } = widened(bounds)?;
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        let (center, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let at = |i: usize| axes[i].dot(center) + shift[i];
        let reach = |i: usize| axes[i].abs().dot(half);
        let (mut nearest, mut farthest) = (-at(2) - reach(2), -at(2) + reach(2));
        // Casters smaller than a texel are enlarged.
        let texel = enlarged * if self.perspective { farthest } else { 1.0 } / self.scale;
        (nearest, farthest) =
            if self.perspective { (nearest - texel, farthest + texel) } else { (1.0, 1.0) };
        if nearest.is_nan() || nearest <= 0.0 {
            return None;
        }
        let side = |i: usize, sign: f64| {
            let (low, high) = (at(i) * sign - reach(i) - texel, at(i) * sign + reach(i) + texel);
            let low = low / if low < 0.0 { nearest } else { farthest };
            let high = high / if high < 0.0 { farthest } else { nearest };
            let texels = |slope: f64, spare: f64| slope * self.scale + self.middle[i] + spare;
            [texels(low, -SPARE), texels(high, SPARE)]
        };
        let beside = [0, 1].map(|i| at(i).abs() + reach(i) + texel);
        Some(Touched { sides: [side(0, 1.0), side(1, -1.0)], nearest, beside, texel })
    }
}

/// Conservative part of a map that a box touches.
struct Touched {
    /// First and last column, first and last row \[texels\].
    sides: [[f64; 2]; 2],
    /// Least depth along the axis \[m\]; 1 in an orthographic view.
    nearest: f64,
    /// Largest distance from the axis, to the right and upwards \[m\].
    beside: [f64; 2],
    /// Width by which casters are enlarged at the farthest depth \[m\].
    texel: f64,
}
