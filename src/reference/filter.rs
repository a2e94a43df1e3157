//! Twin of `wgsl/soften/filter_*.wgsl`: softening of dithered shadows. The visibility behind dithered
//! surfaces is blurred over one window of their pattern and becomes a filter; depths are never blurred.
use super::occlude::is_dithered;
use crate::records::ViewMaps;
use glam::UVec2;

/// Summary of a run of texels.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Share of the window that dithered surfaces block.
    blocked: f32,
    /// Depth of the nearest dithered surface, 1 for none.
    nearest: f32,
    /// Depth behind the closest hole, negative for none, and its distance [texels].
    hole: f32,
    distance: f32,
}

impl Run {
    const EMPTY: Self = Self { blocked: 0.0, nearest: 1.0, hole: -1.0, distance: 1e6 };

    fn add(&mut self, weight: f32, other: &Self, away: u32) {
        self.blocked += weight * other.blocked;
        self.nearest = self.nearest.min(other.nearest);
        let distance = other.distance + away as f32;
        if distance < self.distance {
            self.hole = other.hole;
            self.distance = distance;
        }
    }
}

/// Weight of offset `i` in `-radius..=radius`: a window of `2 * radius` texels, with half weights at its
/// ends.
fn weight(i: i32, radius: i32) -> f32 {
    let whole = 0.5 / radius as f32;
    if i.abs() == radius { 0.5 * whole } else { whole }
}

pub(super) fn around(size: u32, at: u32, radius: i32) -> impl Iterator<Item = (f32, u32, u32)> {
    (-radius..=radius).map(move |i| {
        let place = (at as i32 + i).clamp(0, size as i32 - 1) as u32;
        (weight(i, radius), place, i.unsigned_abs())
    })
}

/// Softens the light behind dithered surfaces; `window` as in [`crate::model::dither::window`].
pub fn filter(maps: &mut ViewMaps, window: u32) {
    let (radius, size) = ((window / 2) as i32, maps.view.size);
    if radius == 0 {
        return;
    }
    let texel = |at: u32| {
        let depth = maps.opaque[at as usize];
        if is_dithered(depth) {
            Run { blocked: 1.0, nearest: depth, ..Run::EMPTY }
        } else {
            Run { hole: depth, distance: 0.0, ..Run::EMPTY }
        }
    };
    let sum = |runs: &mut dyn Iterator<Item = (f32, Run, u32)>| {
        let mut sum = Run::EMPTY;
        for (weight, run, away) in runs {
            sum.add(weight, &run, away);
        }
        sum
    };
    let rows: Vec<Run> = texels(size)
        .map(|(x, y)| {
            let taps = around(size.x, x, radius);
            sum(&mut taps.map(|(weight, x, away)| (weight, texel(y * size.x + x), away)))
        })
        .collect();
    let columns: Vec<Run> = texels(size)
        .map(|(x, y)| {
            let taps = around(size.y, y, radius);
            let row = |y: u32| rows[(y * size.x + x) as usize];
            sum(&mut taps.map(|(weight, y, away)| (weight, row(y), away)))
        })
        .collect();
    for (at, run) in columns.iter().enumerate() {
        if run.blocked > 0.0 {
            maps.filter[at] = maps.filter[at].map(|channel| stored(channel * (1.0 - run.blocked)));
            maps.nearest[at] = maps.nearest[at].min(run.nearest);
        }
        if is_dithered(maps.opaque[at]) {
            maps.opaque[at] = if run.hole < 0.0 { 1.0 } else { run.hole };
        }
    }
}

pub(super) fn texels(size: UVec2) -> impl Iterator<Item = (u32, u32)> {
    (0..size.x * size.y).map(move |i| (i % size.x, i / size.x))
}

/// Rounded like the maps, and not negative.
pub(super) fn stored(light: f32) -> f32 {
    half::f16::from_f32(light.max(0.0)).to_f32()
}
