//! A sparse tree of dense voxels: leaves and tiles where the density is not 0.
use crate::vdb::{LEAF_EDGE, LEAF_VOXELS, MOST_NODES, Tile, Tree, VolumeFault};
use glam::IVec3;
use rayon::prelude::*;

/// Contents of 8^3 voxels.
enum BrickPart {
    Nothing,
    Same(f32),
    Voxels(Box<[f32; LEAF_VOXELS]>),
}

/// The tree of `size` voxels along x, y and z from the origin. Also counts the densities below 0 and the
/// densities that are not finite: they become 0.
pub(crate) fn tree_of(
    size: [usize; 3],
    density: impl Fn([usize; 3]) -> f32 + Sync,
) -> Result<(Tree, [u64; 2]), VolumeFault> {
    const EDGE: usize = LEAF_EDGE as usize;
    let [width, height, depth] = size;
    let part = |[left, low, back]: [usize; 3]| {
        let mut values = Box::new([0.0; LEAF_VOXELS]);
        let mut wrong = [0; 2];
        let end = |start: usize, size: usize| (size - start).min(EDGE);
        for x in 0..end(left, width) {
            for y in 0..end(low, height) {
                for z in 0..end(back, depth) {
                    let value = density([left + x, low + y, back + z]);
                    if value >= 0.0 && value.is_finite() {
                        values[(x * EDGE + y) * EDGE + z] = value;
                    } else {
                        wrong[usize::from(!value.is_finite())] += 1;
                    }
                }
            }
        }
        let first = values[0];
        match values.iter().all(|&value| value == first) {
            true if first == 0.0 => (BrickPart::Nothing, wrong),
            true => (BrickPart::Same(first), wrong),
            false => (BrickPart::Voxels(values), wrong),
        }
    };
    let (mut tree, mut all_wrong) = (Tree::default(), [0, 0]);
    let rows = height.div_ceil(EDGE);
    // Slices of leaves, one after another, bound the memory that is held twice.
    for back in (0..depth).step_by(EDGE) {
        let row = |row: usize| {
            let lefts = (0..width).step_by(EDGE);
            let parts = lefts.map(|left| (left, part([left, row * EDGE, back])));
            parts
                .filter(|(_, (part, wrong))| {
                    !matches!(part, BrickPart::Nothing) || *wrong != [0; 2]
                })
                .collect::<Vec<_>>()
        };
        let slice: Vec<_> = (0..rows).into_par_iter().map(row).collect();
        for (row, parts) in slice.into_iter().enumerate() {
            for (left, (part, wrong)) in parts {
                all_wrong = std::array::from_fn(|i| all_wrong[i] + wrong[i]);
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
        if tree.leaves.len() + tree.tiles.len() > MOST_NODES {
            let message = format!("its voxels need more than {MOST_NODES} bricks");
            let help = "set `window` or `clip` so that less of it is above 0, or resample it with larger voxels";
            return Err(VolumeFault::new(message, help));
        }
    }
    Ok((tree, all_wrong))
}
