//! Ranges of an emitter's numbers.
use super::{EmitterShape, Forces, MAX_BOXES};
use crate::model::bounds::FARTHEST;
use glam::Vec3;
use std::ops::RangeInclusive;

/// Largest speed, acceleration or rate.
const MOST: f32 = 1e3;
const BOTH_WAYS: RangeInclusive<f32> = -MOST..=MOST;

impl Default for Forces {
    /// 100 particles a second that live one second and rise at 1 m/s from a point, in still air.
    fn default() -> Self {
        Self {
            seed: 0,
            rate: 100.0,
            lifetime: [1.0; 2],
            shape: EmitterShape::Point,
            position: Vec3::ZERO,
            extent: Vec3::splat(0.2),
            velocity: Vec3::Y,
            spread: 0.0,
            gravity: 0.0,
            buoyancy: 0.0,
            drag: 0.0,
            wind: Vec3::ZERO,
            turbulence: 0.0,
            frequency: 1.0,
            evolve: 0.0,
            ground: None,
            boxes: Vec::new(),
            bounce: 0.2,
            slide: 0.8,
            path: Vec::new(),
            origin: Vec3::ZERO,
        }
    }
}

impl Forces {
    /// The first field that is out of its range.
    pub fn problem(&self) -> Option<&'static str> {
        let is_near = |v: &Vec3| v.abs().cmple(Vec3::splat(FARTHEST)).all();
        let [least, most] = self.lifetime;
        let has_order =
            |[low, high]: &[Vec3; 2]| is_near(low) && is_near(high) && low.cmplt(*high).all();
        let is_row =
            |&[seconds, x, y, z]: &[f32; 4]| seconds.is_finite() && is_near(&Vec3::new(x, y, z));
        let vectors = [self.position, self.velocity, self.wind, self.origin, self.extent];
        [
            ((1e-3..=1e6).contains(&self.rate), "its rate must be 0.001 to 1,000,000 a second"),
            (0.02 <= least && least <= most && most <= 600.0, {
                "its lifetime must be 0.02 to 600 s, the shortest first"
            }),
            (vectors.iter().all(is_near), {
                "its position, velocity, wind, origin and extent must be finite and within 1e7"
            }),
            (self.extent.min_element() >= 0.0, "its extent must not be negative"),
            ((0.0..=MOST).contains(&self.spread), "its spread must be 0 to 1000 m/s"),
            (BOTH_WAYS.contains(&self.gravity), "its gravity must be -1000 to 1000 m/s^2"),
            (BOTH_WAYS.contains(&self.buoyancy), "its buoyancy must be -1000 to 1000 m/s^2"),
            ((0.0..=MOST).contains(&self.drag), "its drag must be 0 to 1000 1/s"),
            ((0.0..=MOST).contains(&self.turbulence), "its turbulence must be 0 to 1000 m/s"),
            ((1e-3..=MOST).contains(&self.frequency), "its frequency must be 0.001 to 1000 1/m"),
            (BOTH_WAYS.contains(&self.evolve), "its evolve must be -1000 to 1000 m/s"),
            (self.ground.is_none_or(|y| y.abs() <= FARTHEST), "its ground must be within 1e7 m"),
            (self.boxes.len() <= MAX_BOXES, "it must have at most 8 boxes"),
            (self.boxes.iter().all(has_order), {
                "each box must have its lower corner first, and be within 1e7 m"
            }),
            ((0.0..=1.0).contains(&self.bounce), "its bounce must be 0 to 1"),
            ((0.0..=1.0).contains(&self.slide), "its slide must be 0 to 1"),
            (self.path.iter().all(is_row) && self.path.is_sorted_by(|a, b| a[0] < b[0]), {
                "the rows of its path must be finite, within 1e7 m, and their seconds ascend"
            }),
        ]
        .into_iter()
        .find_map(|(is_met, problem)| (!is_met).then_some(problem))
    }
}
