//! Groups: spatially coherent runs of casters along a Morton curve.
use crate::model::Bounds;
use glam::{UVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Bits of a cell's coordinate.
const BITS: u32 = 10;
/// Points sampled to find the extent of most points.
const SAMPLES: usize = 1024;

/// Indices of the points in Morton order (Morton 1966). The cells cover the middle 98 of 100 points and as
/// much around them, so that outliers do not coarsen them.
pub fn morton(points: &[Vec3]) -> Vec<u32> {
    let step = points.len().div_ceil(SAMPLES).max(1);
    let mut least = Vec3::ZERO;
    let mut edge = Vec3::ONE;
    for axis in 0..3 {
        let mut sample: Vec<f32> =
            points.iter().step_by(step).map(|p| p[axis]).filter(|v| v.is_finite()).collect();
        if sample.is_empty() {
            continue;
        }
        sample.sort_unstable_by(f32::total_cmp);
        let rank = sample.len() / 100;
        let (low, high) = (sample[rank], sample[sample.len() - 1 - rank]);
        let width = (high - low).max(f32::MIN_POSITIVE);
        (least[axis], edge[axis]) = (low - width, 3.0 * width);
    }
    // Cubic cells, so that a group is as deep as it is wide.
    let per_metre = (1 << BITS) as f32 / edge.max_element();
    // A NaN becomes 0. The index below the code keeps equal ones in order.
    let code = |point: Vec3| u64::from(morton_code(((point - least) * per_metre).as_uvec3()));
    let key = |(index, &point): (usize, &Vec3)| code(point) << 32 | index as u64;
    let mut keys: Vec<u64> = points.par_iter().enumerate().map(key).collect();
    keys.par_sort_unstable();
    keys.into_iter().map(|key| key as u32).collect()
}

/// Place of a cell along a Z-order curve (Morton 1966): the bits of its coordinates in turn. Cells past the
/// last count as the last.
pub fn morton_code(cell: UVec3) -> u32 {
    let spread = |v: u32| {
        let v = (v | v << 16) & 0x0300_00ff;
        let v = (v | v << 8) & 0x0300_f00f;
        let v = (v | v << 4) & 0x030c_30c3;
        (v | v << 2) & 0x0924_9249
    };
    let [x, y, z] = cell.min(UVec3::splat((1 << BITS) - 1)).to_array().map(spread);
    x | y << 1 | z << 2
}

/// Cuts a sequence of `count` boxes into groups of at most `most`. A box that starts an object starts a
/// group; so does one that would add more than half of the surface to a group that already has `least` boxes,
/// and one far from the one before, as long as such groups are few.
pub fn cut(
    count: u32,
    box_of: impl Fn(u32) -> (Bounds, bool),
    least: u32,
    most: u32,
) -> Vec<Range<u32>> {
    /// Distance of an outlier, in median distances of neighbours.
    const FAR: f32 = 32.0;
    let step = |index: u32| (box_of(index).0.center() - box_of(index - 1).0.center()).length();
    let mut steps: Vec<f32> =
        (1..count).step_by((count as usize).div_ceil(SAMPLES).max(1)).map(step).collect();
    steps.sort_unstable_by(f32::total_cmp);
    let far = steps.get(steps.len() / 2).map_or(f32::INFINITY, |usual| FAR * usual);
    let enough = (count / least.max(1)) as usize + 64;
    let mut groups = Vec::new();
    let mut group = 0..0;
    let mut around = Bounds::EMPTY;
    let mut center = Vec3::ZERO;
    for index in 0..count {
        let (bounds, starts) = box_of(index);
        let before = std::mem::replace(&mut center, bounds.center());
        let with = union(around, bounds);
        let len = group.len() as u32;
        let ends = starts
            || len >= most
            || len >= least && with.half_area() > 1.5 * around.half_area()
            || center.distance(before) > far && groups.len() < enough;
        if len > 0 && ends {
            groups.push(group.clone());
            group = index..index;
            around = bounds;
        } else {
            around = with;
        }
        group.end = index + 1;
    }
    if !group.is_empty() {
        groups.push(group);
    }
    groups
}

fn union(a: Bounds, b: Bounds) -> Bounds {
    Bounds { min: a.min.min(b.min), max: a.max.max(b.max) }
}
