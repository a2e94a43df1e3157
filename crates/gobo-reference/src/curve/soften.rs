//! CPU reference of `wgsl/soften/curve_columns.wgsl`: softening of curves under dithered shadows.
//!
//! The light of a texel becomes `C(z) V(z)`. `V` is the visibility through dithered surfaces over one window
//! of their pattern, as one ramp with the mean and variance of their depths. `C` is the texel's own curve; if
//! a dithered surface blocks the texel, so that its curve ends there, `C` is the curve of the closest hole.
//! Windows are clipped to the map.
use super::{DEPTHS, fixed};
use crate::{
    occlude::is_dithered,
    soften::{around, texels},
};
use glam::{BVec3, Vec3};
use gobo::records::{
    PackedNode, ViewMaps,
    curve::{packed, unpack},
};

/// Summary of the dithered surfaces in a run of texels.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// Blocked share of the window, per channel.
    blocked: Vec3,
    /// Depths of the nearest and the farthest surface; 1 and -1 without one.
    nearest: f32,
    farthest: f32,
    /// Means over the window and the channels: of the blocked share, of its product with the depth, and with
    /// the depth's square.
    moments: Vec3,
    /// Column of the closest texel with a hole, negative without one; its row, and its distance \[texels\].
    hole: f32,
    row: u32,
    distance: f32,
}

impl Run {
    const EMPTY: Self = Self {
        blocked: Vec3::ZERO,
        nearest: 1.0,
        farthest: -1.0,
        moments: Vec3::ZERO,
        hole: -1.0,
        row: 0,
        distance: 1e6,
    };

    /// Run of one texel with opaque depths per channel.
    fn of(depths: [f32; 3], x: u32) -> Self {
        let dithered = BVec3::from_array(depths.map(is_dithered));
        let depths = Vec3::from_array(depths);
        let blocked = Vec3::select(dithered, Vec3::ONE, Vec3::ZERO);
        let all = dithered.all();
        Self {
            blocked,
            nearest: Vec3::select(dithered, depths, Vec3::ONE).min_element(),
            farthest: Vec3::select(dithered, depths, Vec3::NEG_ONE).max_element(),
            moments: Vec3::new(
                blocked.dot(Vec3::ONE),
                blocked.dot(depths),
                blocked.dot(depths * depths),
            ) / 3.0,
            hole: if all { -1.0 } else { x as f32 },
            row: 0,
            distance: if all { 1e6 } else { 0.0 },
        }
    }

    fn sum(runs: impl Iterator<Item = (f32, Self, u32)>) -> Self {
        runs.fold(Self::EMPTY, |mut sum, (weight, run, away)| {
            sum.blocked += weight * run.blocked;
            sum.nearest = sum.nearest.min(run.nearest);
            sum.farthest = sum.farthest.max(run.farthest);
            sum.moments += weight * run.moments;
            let distance = run.distance + away as f32;
            if distance < sum.distance {
                (sum.hole, sum.row, sum.distance) = (run.hole, run.row, distance);
            }
            sum
        })
    }

    /// Depths at which the ramp starts and ends \[light depth\].
    fn ramp(&self) -> (f32, f32) {
        let mean = self.moments.y / self.moments.x;
        let variance = (self.moments.z / self.moments.x - mean * mean).max(0.0);
        let most = (mean - self.nearest).min(self.farthest - mean);
        let half = (3.0 * variance).sqrt().min(most).max(0.0);
        (mean - half, mean + half)
    }
}

/// A node with its ramp.
#[derive(Clone, Copy, Debug)]
struct NodeRamp {
    /// Start and length \[fixed point\].
    start: f32,
    length: f32,
    passed: Vec3,
}

impl NodeRamp {
    fn of(node: PackedNode, grows: bool) -> Self {
        let (start, length, passed) = unpack(node, grows);
        Self { start, length, passed }
    }

    fn taken(&self) -> f32 {
        (Vec3::ONE - self.passed).abs().element_sum()
    }

    fn middle(&self) -> f32 {
        self.start + 0.5 * self.length
    }

    /// The joined ramp, with the mean depth and the variance of both losses.
    fn joined(self, other: Self, grows: bool) -> PackedNode {
        let both = [self, other];
        let all = self.taken() + other.taken();
        let share = both.map(|ramp| ramp.taken() / all.max(1e-9));
        let low = self.start.min(other.start);
        let high = (self.start + self.length).max(other.start + other.length);
        let mean = share[0] * self.middle() + share[1] * other.middle();
        let spread = |i: usize| {
            let (off, length) = (both[i].middle() - mean, both[i].length);
            share[i] * (off * off + length * length * (1.0 / 12.0))
        };
        let half = (3.0 * (spread(0) + spread(1))).sqrt().min(mean - low).min(high - mean).max(0.0);
        let start = (mean - half).round_ties_even().clamp(1.0, DEPTHS) as u32;
        let passed = self.passed * other.passed;
        let most = if grows { f32::MAX } else { 1.0 };
        packed(start, 2.0 * half, passed.min(Vec3::splat(most)), grows)
    }
}

/// Adds a ramp to a curve: in a free node, or joined with the node where that costs least.
fn soften_nodes(nodes: &mut [PackedNode], ramp: PackedNode, grows: bool) {
    let added = NodeRamp::of(ramp, grows);
    let (mut best, mut least) = ((0, ramp), f32::MAX);
    let mut light = Vec3::ONE;
    for (k, &node) in nodes.iter().enumerate() {
        let node = NodeRamp::of(node, grows);
        let free = node.start == 0.0;
        let apart = (node.middle() - added.middle()).abs();
        let cost = light.element_sum() * (node.taken() + added.taken()) * apart;
        let cost = if free { -1.0 } else { cost };
        if cost < least {
            least = cost;
            best = (k, if free { ramp } else { node.joined(added, grows) });
        }
        light *= node.passed;
    }
    nodes[best.0] = best.1;
}

/// Softens curves before [`crate::soften::soften`], which changes the opaque depths.
pub fn soften_curves(maps: &mut ViewMaps, window: u32) {
    let (radius, size) = ((window / 2) as i32, maps.view.size);
    let Some(curve) = maps.curve.as_ref().filter(|_| radius > 0) else { return };
    let depths = |at: usize| maps.colored.get(at).copied().unwrap_or([maps.opaque[at]; 3]);
    let rows: Vec<Run> = texels(size)
        .map(|(x, y)| {
            let taps = around(size.x, x, radius);
            let run = |x: u32| Run::of(depths((y * size.x + x) as usize), x);
            Run::sum(taps.map(|(weight, x, away)| (weight, run(x), away)))
        })
        .collect();
    let mut soft = curve.clone();
    for (at, (x, y)) in texels(size).enumerate() {
        let taps = around(size.y, y, radius);
        let row = |y: u32| Run { row: y, ..rows[(y * size.x + x) as usize] };
        let run = Run::sum(taps.map(|(weight, y, away)| (weight, row(y), away)));
        if run.moments.x <= 0.0 {
            continue;
        }
        let source =
            if run.hole < 0.0 { at } else { (run.row * size.x + run.hole as u32) as usize };
        let (start, end) = run.ramp();
        let passing = (Vec3::ONE - run.blocked).max(Vec3::ZERO);
        let ramp = packed(fixed(start), (end - start) * DEPTHS, passing, curve.gain);
        let mut nodes = curve.nodes_of(source).to_vec();
        soften_nodes(&mut nodes, ramp, curve.gain);
        soft.packed[at * curve.nodes..][..curve.nodes].copy_from_slice(&nodes);
    }
    maps.curve = Some(soft);
}
