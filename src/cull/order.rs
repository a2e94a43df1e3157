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

/// Cuts a row of casters into groups of at most `most`. Where the next one would add more than half
/// of the surface to a group that has `least` already, the next group starts.
pub fn cut(boxes: impl IntoIterator<Item = Bounds>, least: u32, most: u32) -> Vec<Range<u32>> {
    let half_area = |bounds: &Bounds| {
        let edge = bounds.max - bounds.min;
        edge.x * edge.y + edge.y * edge.z + edge.z * edge.x
    };
    let mut groups = Vec::new();
    let mut group = 0..0;
    let mut around = Bounds::EMPTY;
    for bounds in boxes {
        let with = Bounds { min: around.min.min(bounds.min), max: around.max.max(bounds.max) };
        let full = group.len() as u32 >= most;
        let far = group.len() as u32 >= least && half_area(&with) > 1.5 * half_area(&around);
        if full || far && !group.is_empty() {
            groups.push(group.clone());
            group = group.end..group.end;
            around = bounds;
        } else {
            around = with;
        }
        group.end += 1;
    }
    if !group.is_empty() {
        groups.push(group);
    }
    groups
}
