//! A sparse tree of dense voxels: leaves and tiles where the density is not 0.
use crate::vdb::{Bricks, LEAF_EDGE, LEAF_VOXELS, MOST_NODES, Tile, Tree, VolumeFault};
use glam::{DAffine3, DVec3, IVec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Largest edge of the cubes whose voxels are averaged, if all voxels are too many.
const COARSEST: usize = 16;

/// Bricks of dense voxels.
pub(crate) struct DenseBricks {
    pub(crate) bricks: Bricks,
    /// Numbers of densities below 0 and of densities that are not finite: they count as 0.
    pub(crate) wrong: [u64; 2],
    /// Edge of the cubes whose mean is a voxel of the bricks; 1 if all voxels fit.
    pub(crate) step: usize,
}

impl DenseBricks {
    /// Index space of the file's voxels from that of the bricks, each with whole numbers at voxel centres.
    pub(crate) fn file_from_index(&self) -> DAffine3 {
        let step = self.step as f64;
        let mut affine = DAffine3::from_scale(DVec3::splat(step));
        affine.translation = DVec3::splat(0.5 * (step - 1.0));
        affine
    }
}

/// The bricks of `size` voxels along x, y and z from the origin: of all voxels, or else of the means of
/// cubes of 2^3, 4^3 and so on, the smallest that fit.
pub(crate) fn fitting_bricks(
    size: [usize; 3],
    density: impl Fn([usize; 3]) -> f32 + Sync,
) -> Result<DenseBricks, VolumeFault> {
    bricks_within(MOST_NODES, size, density)
}

/// Like [`fitting_bricks`], of at most `most` nodes.
fn bricks_within(
    most: usize,
    size: [usize; 3],
    density: impl Fn([usize; 3]) -> f32 + Sync,
) -> Result<DenseBricks, VolumeFault> {
    let help =
        "set `window` or `clip` so that less of it is above 0, or resample it with larger voxels";
    let mut fault = VolumeFault::new(format!("its voxels need more than {most} bricks"), help);
    let mut step = 1;
    while step <= COARSEST {
        let wrong = [const { AtomicU64::new(0) }; 2];
        let valid = |voxel: [usize; 3]| {
            let value = density(voxel);
            if value >= 0.0 && value.is_finite() {
                return value;
            }
            wrong[usize::from(!value.is_finite())].fetch_add(1, Relaxed);
            0.0
        };
        let mean = |first: [usize; 3]| {
            if step == 1 {
                return valid(first);
            }
            let [x, y, z] = std::array::from_fn(|i| {
                let start = first[i] * step;
                start..(start + step).min(size[i])
            });
            let mut sum = 0.0;
            for z in z {
                for y in y.clone() {
                    sum += x.clone().map(|x| f64::from(valid([x, y, z]))).sum::<f64>();
                }
            }
            (sum / step.pow(3) as f64) as f32
        };
        if let Some(tree) = tree_of(most, size.map(|edge| edge.div_ceil(step)), mean)? {
            match tree.into_bricks() {
                Ok(bricks) => {
                    return Ok(DenseBricks {
                        bricks,
                        wrong: wrong.map(AtomicU64::into_inner),
                        step,
                    });
                }
                Err(error) => fault = error,
            }
        }
        step *= 2;
    }
    Err(fault)
}

/// Contents of 8^3 voxels.
enum BrickPart {
    Nothing,
    Same(f32),
    Voxels(Box<[f32; LEAF_VOXELS]>),
}

/// The tree of `size` voxels along x, y and z from the origin, of densities of at least 0; `None` if it has
/// more than `most` nodes.
fn tree_of(
    most: usize,
    size: [usize; 3],
    density: impl Fn([usize; 3]) -> f32 + Sync,
) -> Result<Option<Tree>, VolumeFault> {
    const EDGE: usize = LEAF_EDGE as usize;
    let [width, height, depth] = size;
    let part = |[left, low, back]: [usize; 3]| {
        let mut values = Box::new([0.0; LEAF_VOXELS]);
        let end = |start: usize, size: usize| (size - start).min(EDGE);
        for x in 0..end(left, width) {
            for y in 0..end(low, height) {
                for z in 0..end(back, depth) {
                    values[(x * EDGE + y) * EDGE + z] = density([left + x, low + y, back + z]);
                }
            }
        }
        let first = values[0];
        match values.iter().all(|&value| value == first) {
            true if first == 0.0 => BrickPart::Nothing,
            true => BrickPart::Same(first),
            false => BrickPart::Voxels(values),
        }
    };
    let mut tree = Tree::default();
    let rows = height.div_ceil(EDGE);
    // Slices of leaves, one after another, bound the memory that is held twice.
    for back in (0..depth).step_by(EDGE) {
        let row = |row: usize| {
            let lefts = (0..width).step_by(EDGE);
            let parts = lefts.map(|left| (left, part([left, row * EDGE, back])));
            parts.filter(|(_, part)| !matches!(part, BrickPart::Nothing)).collect::<Vec<_>>()
        };
        let slice: Vec<_> = (0..rows).into_par_iter().map(row).collect();
        for (row, parts) in slice.into_iter().enumerate() {
            for (left, part) in parts {
                let origin = [left, row * EDGE, back].map(|at| at as i32);
                let origin = IVec3::from_array(origin);
                match part {
                    BrickPart::Nothing => {}
                    BrickPart::Same(value) => {
                        tree.tiles.push(Tile { origin, edge: LEAF_EDGE, value });
                    }
                    BrickPart::Voxels(values) => {
                        tree.leaves.push(origin);
                        tree.values.try_reserve(LEAF_VOXELS).map_err(|_| {
                            let message = format!("no memory for {} leaves", tree.leaves.len());
                            let help = "use a smaller array, or a machine with more memory";
                            VolumeFault::new(message, help)
                        })?;
                        tree.values.extend_from_slice(&values[..]);
                    }
                }
            }
        }
        if tree.leaves.len() + tree.tiles.len() > most {
            return Ok(None);
        }
    }
    Ok(Some(tree))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means of cubes add up to the sum of all voxels, also where the last cube is cut off.
    #[test]
    fn what_does_not_fit_is_averaged() {
        let size = [41, 17, 16];
        let density = |[x, y, z]: [usize; 3]| match [x, y, z] {
            [3, 3, 3] => f32::NAN,
            [5, 5, 5] => -1.0,
            _ => (1 + (x + 3 * y + 7 * z) % 32) as f32,
        };
        let whole = bricks_within(36, size, density).unwrap();
        assert_eq!((whole.step, whole.wrong), (1, [1, 1]));
        let coarse = bricks_within(35, size, density).unwrap();
        assert_eq!((coarse.step, coarse.wrong), (2, [1, 1]));
        // The voxels 0 to 7 of each brick; its last ones are those of the next.
        let sum = |bricks: &DenseBricks| -> f64 {
            let own = |brick: &gobo::model::Brick| {
                let values = brick.voxels().expect("voxels").values().zip(0..);
                let inner = values.filter(|(_, i)| i % 9 < 8 && i / 9 % 9 < 8 && i / 81 < 8);
                inner.map(|(value, _)| f64::from(value)).sum::<f64>()
            };
            bricks.bricks.bricks.iter().map(own).sum()
        };
        assert!((sum(&coarse) * 8.0 / sum(&whole) - 1.0).abs() < 1e-3);
        let first = coarse.file_from_index().transform_point3(DVec3::ZERO);
        assert_eq!(first, DVec3::splat(0.5));
        let next = coarse.file_from_index().transform_point3(DVec3::ONE);
        assert_eq!(next, DVec3::splat(2.5));
        assert!(bricks_within(0, size, density).is_err());
    }
}
