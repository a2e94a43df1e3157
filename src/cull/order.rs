//! Groups: casters that lie together, in order along a curve through space.
use crate::{
    cpu::{self, Pair},
    scene::Bounds,
};
use glam::{UVec3, Vec3};
use std::ops::Range;

/// Bits of a cell's coordinate.
const BITS: u32 = 10;
/// Points that say where most of them are.
const SAMPLES: usize = 1024;

/// The points' indices in Morton order (Morton 1966). Few that lie far from all others do not
/// coarsen the cells: those are laid over the middle 98 of 100 points and as much around them.
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
    // Cubes, so that a group is as deep as it is wide.
    let per_metre = (1 << BITS) as f32 / edge.max_element();
    let mut pairs: Vec<Pair> = (0..)
        .zip(points)
        .map(|(value, &point)| {
            // A NaN becomes 0.
            let cell = ((point - least) * per_metre).as_uvec3().min(UVec3::splat((1 << BITS) - 1));
            let key = spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2;
            Pair { key, value }
        })
        .collect();
    cpu::sort(&mut pairs, &mut Vec::new(), 0..3 * BITS);
    pairs.into_iter().map(|pair| pair.value).collect()
}

/// Two empty bits before each of ten.
fn spread(v: u32) -> u32 {
    let v = (v | v << 16) & 0x0300_00ff;
    let v = (v | v << 8) & 0x0300_f00f;
    let v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// Cuts a row of `count` boxes into groups of at most `most`. A box that starts an object starts a
/// group; so does one that would add more than half of the surface to a group that has `least`
/// already, and the first of some that lie far from a group of any size.
pub fn cut(
    count: u32,
    box_of: impl Fn(u32) -> (Bounds, bool),
    least: u32,
    most: u32,
) -> Vec<Range<u32>> {
    /// Boxes that say where a place is; fewer by themselves are no group.
    const PLACE: u32 = 8;
    let mut groups = Vec::new();
    let mut group = 0..0;
    let mut around = Bounds::EMPTY;
    for index in 0..count {
        let (bounds, starts) = box_of(index);
        let with = union(around, bounds);
        let len = group.len() as u32;
        let more = with.half_area() / around.half_area();
        let is_far = || {
            let ahead = (index..count.min(index + PLACE)).map(|i| box_of(i).0);
            let ahead = ahead.fold(Bounds::EMPTY, union);
            union(around, ahead).half_area() > 8.0 * (around.half_area() + ahead.half_area())
        };
        let ends = starts
            || len >= most
            || len >= least && more > 1.5
            || len >= PLACE && more > 4.0 && is_far();
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
