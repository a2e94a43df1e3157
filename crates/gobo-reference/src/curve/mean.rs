//! CPU reference of `wgsl/curve/mean.wgsl`: the mean of several curves, in a few nodes. The depth range is
//! cut at the longest gaps; each part becomes a ramp of the same mean depth and spread.
use super::{DEPTHS, Storing, unpack};
use glam::Vec3;
use gobo::records::{PackedNode, curve::LEAST};

/// Bins of depth in which gaps are searched.
pub const BINS: u32 = 32;

/// Depth range over which the light falls linearly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IntegerRamp {
    /// Start \[fixed point\], at least 1.
    pub start: u32,
    /// Length \[fixed point\].
    pub length: f32,
    /// Drop of the mean's light.
    pub drop: Vec3,
}

impl IntegerRamp {
    /// Twice the middle of its range.
    fn middle(&self) -> u32 {
        2 * self.start + self.length.round_ties_even() as u32
    }

    fn weight(&self) -> f32 {
        self.drop.abs().element_sum()
    }
}

/// Adds the ramps of a curve whose weight in the mean is `share`. Returns the light behind the curve.
pub(crate) fn add_nodes(
    nodes: &[PackedNode],
    share: f32,
    grows: bool,
    ramps: &mut Vec<IntegerRamp>,
) -> Vec3 {
    let mut left = Vec3::ONE;
    for &node in nodes {
        let (start, length, passed) = unpack(node, grows);
        if start > 0.0 {
            let light = left * passed;
            ramps.push(IntegerRamp { start: start as u32, length, drop: (left - light) * share });
            left = light;
        }
    }
    left
}

/// Writes the nodes of a mean curve with the given ramps.
pub(crate) fn merge(ramps: &[IntegerRamp], nodes: &mut [PackedNode], grows: bool) {
    let counted = || ramps.iter().filter(|ramp| ramp.weight() > 0.0);
    let low = counted().map(IntegerRamp::middle).min().unwrap_or(0);
    let high = counted().map(IntegerRamp::middle).max().unwrap_or(0);
    let bin = |ramp: &IntegerRamp| (ramp.middle() - low) * BINS / (high - low + 1);
    let cuts = cuts(counted().fold(0, |mask, ramp| mask | 1 << bin(ramp)), nodes.len() - 1);
    // Index of the part that holds a ramp.
    let part =
        |ramp: &IntegerRamp| (cuts & (2u32 << bin(ramp)).wrapping_sub(1)).count_ones() as usize;
    let mut light = Vec3::ONE;
    let least = Vec3::splat(if grows { LEAST } else { 0.0 });
    let mut storing = Storing::new(grows);
    for (number, node) in nodes.iter_mut().enumerate() {
        let (mut weight, mut sum, mut square) = (0.0, 0.0, 0.0);
        let (mut first, mut end, mut middle) = (DEPTHS, 0.0_f32, None);
        for ramp in counted().filter(|ramp| part(ramp) == number) {
            let (start, drop) = (ramp.start as f32, ramp.weight());
            let middle = *middle.get_or_insert(start + 0.5 * ramp.length);
            let off = start + 0.5 * ramp.length - middle;
            weight += drop;
            sum += drop * off;
            square += drop * (off * off + ramp.length * ramp.length * (1.0 / 12.0));
            first = first.min(start);
            end = end.max(start + ramp.length);
            light -= ramp.drop;
        }
        let (mut start, mut length) = (0, 0.0);
        if let Some(middle) = middle {
            let off = sum / weight;
            let spread = (square / weight - off * off).max(0.0);
            let mean = middle + off;
            let half = (3.0 * spread).sqrt().min(mean - first).min(end - mean).max(0.0);
            start = ((mean - half).round_ties_even() as u32).clamp(1, 65535);
            length = 2.0 * half;
        }
        *node = storing.store(start, length, light.max(least));
    }
}

/// Mask of the bins at which a new part begins: after the `most` longest gaps, the first among equal ones.
fn cuts(mask: u32, most: usize) -> u32 {
    let bins: Vec<u32> = (0..BINS).filter(|bin| mask >> bin & 1 == 1).collect();
    let mut gaps: Vec<_> = bins.windows(2).map(|pair| (pair[1] - pair[0], pair[1])).collect();
    gaps.sort_by_key(|&(gap, _)| std::cmp::Reverse(gap));
    gaps.iter().take(most).fold(0, |cuts, gap| cuts | 1 << gap.1)
}
