//! Extent of receivers given as points: boxes around neighbouring points.
use crate::model::Bounds;
use glam::Vec3;
use std::collections::HashMap;

/// Most boxes.
const MAX: usize = 4096;
/// Edge of the first cells \[m\]: points this close are one at 1 km from the origin.
const FIRST_CELL: f64 = 1.0 / 16384.0;

/// Extent of any number of points: at most 4,096 boxes, each around the points in one cell of a lattice. The
/// views of `Renderer::point_look_up` are as deep as these boxes.
#[derive(Clone, Debug)]
pub struct Receivers {
    /// Edge of a cell \[m\].
    cell: f64,
    boxes: HashMap<[i64; 3], Bounds>,
}

impl Default for Receivers {
    /// No points.
    fn default() -> Self {
        Self { cell: FIRST_CELL, boxes: HashMap::new() }
    }
}

impl Receivers {
    /// Adds a point, world space \[m\].
    pub fn add(&mut self, point: Vec3) {
        let cell = point.as_dvec3() / self.cell;
        self.add_box(cell.floor().to_array().map(|i| i as i64), Bounds { min: point, max: point });
        while self.boxes.len() > MAX {
            self.cell *= 2.0;
            for (cell, bounds) in std::mem::take(&mut self.boxes) {
                self.add_box(cell.map(|i| i >> 1), bounds);
            }
        }
    }

    fn add_box(&mut self, cell: [i64; 3], bounds: Bounds) {
        let all = self.boxes.entry(cell).or_insert(Bounds::EMPTY);
        *all = all.with(&bounds);
    }

    /// The boxes, in no order.
    pub(crate) fn boxes(&self) -> impl Iterator<Item = &Bounds> {
        self.boxes.values()
    }

    /// The same receivers in a scene that is translated \[m\].
    pub fn moved(mut self, by: Vec3) -> Self {
        for bounds in self.boxes.values_mut() {
            *bounds = Bounds { min: bounds.min + by, max: bounds.max + by };
        }
        self
    }
}

impl Extend<Vec3> for Receivers {
    fn extend<I: IntoIterator<Item = Vec3>>(&mut self, points: I) {
        points.into_iter().for_each(|point| self.add(point));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: impl IntoIterator<Item = Vec3>) -> Receivers {
        let mut receivers = Receivers::default();
        receivers.extend(points);
        receivers
    }

    #[test]
    fn few_points_are_a_box_each() {
        let points = [Vec3::ZERO, Vec3::new(-1e7, 3.0, 0.5), Vec3::splat(0.001), Vec3::ZERO];
        let boxes: Vec<_> = of(points).boxes().copied().collect();
        assert_eq!(boxes.len(), 3);
        assert!(points.iter().all(|&p| boxes.contains(&Bounds { min: p, max: p })));
    }

    /// One far away leaves the boxes of the others small.
    #[test]
    fn many_points_are_boxes_of_their_cells() {
        let place = |i: usize| Vec3::new((i % 300) as f32, (i / 300) as f32, -7.5) * 0.03;
        let all = (0..90_000).map(place).chain([Vec3::new(9e6, -9e6, 4.0)]);
        let receivers = of(all.clone());
        let boxes: Vec<_> = receivers.boxes().copied().collect();
        assert!((MAX / 5..=MAX).contains(&boxes.len()), "{}", boxes.len());
        let is_in = |p: Vec3, b: &Bounds| p.cmpge(b.min).all() && p.cmple(b.max).all();
        assert!(all.step_by(97).all(|p| boxes.iter().any(|b| is_in(p, b))));
        let widest = boxes.iter().map(|b| (b.max - b.min).max_element()).fold(0.0, f32::max);
        assert!(widest < 0.5, "{widest} m");
    }
}
