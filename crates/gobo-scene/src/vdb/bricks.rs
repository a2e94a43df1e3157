//! Bricks of a tree's voxels: leaves with the first voxels of their neighbours, and boxes of one value.
use super::{
    input::VolumeFault,
    tree::{LEAF_EDGE, LEAF_VOXELS, MOST_NODES, Tile, Tree, UPPER_EDGE},
};
use crate::limits::has_memory;
use glam::{IVec3, UVec3};
use gobo::model::{BRICK_VALUES, Brick, Density, Voxels};
use half::f16;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

/// The bricks of a tree.
#[derive(Debug, Default)]
pub(crate) struct Bricks {
    pub(crate) bricks: Vec<Brick>,
    /// Density of the grid per density of its bricks: a power of two, 1 unless half floats could not hold its
    /// densities.
    pub(crate) scale: f32,
    /// Number of voxels and tiles with a value below 0: they count as 0.
    pub(crate) negative: u64,
    /// Number of voxels and tiles with a value that is not finite: they count as 0.
    pub(crate) not_finite: u64,
}

/// Edges of tiles \[voxels\].
const EDGES: [i32; 3] = [LEAF_EDGE, 128, UPPER_EDGE];

/// Source of a brick's voxels.
#[derive(Clone, Copy)]
pub(super) enum VoxelSource<'a> {
    /// Values of a leaf, z first.
    Leaf(&'a [f32]),
    Constant(f32),
}

impl VoxelSource<'_> {
    pub(super) fn at(self, voxel: IVec3) -> f32 {
        match self {
            Self::Leaf(values) => values[((voxel.x * 8 + voxel.y) * 8 + voxel.z) as usize],
            Self::Constant(value) => value,
        }
    }
}

/// The voxels of a tree by their coordinates.
pub(super) struct VoxelSources<'a> {
    tree: &'a Tree,
    /// Value of voxels that nothing sets.
    unset: f32,
    leaves: HashMap<IVec3, usize>,
    tiles: HashMap<(i32, IVec3), f32>,
}

impl<'a> VoxelSources<'a> {
    pub(super) fn new(tree: &'a Tree, unset: f32) -> Self {
        Self {
            tree,
            unset,
            leaves: tree.leaves.iter().copied().zip(0..).collect(),
            tiles: tree.tiles.iter().map(|tile| ((tile.edge, tile.origin), tile.value)).collect(),
        }
    }

    /// Source of the 8^3 voxels from `origin` on.
    pub(super) fn source(&self, origin: IVec3) -> VoxelSource<'a> {
        if let Some(&leaf) = self.leaves.get(&origin) {
            return VoxelSource::Leaf(&self.tree.values[leaf * LEAF_VOXELS..][..LEAF_VOXELS]);
        }
        let tile =
            |&edge: &i32| self.tiles.get(&(edge, origin.div_euclid(IVec3::splat(edge)) * edge));
        VoxelSource::Constant(EDGES.iter().find_map(tile).copied().unwrap_or(self.unset))
    }

    /// Sources of the 8^3 voxels from `origin` on and of their upper neighbours.
    fn sources(&self, origin: IVec3) -> [VoxelSource<'a>; 8] {
        std::array::from_fn(|i| {
            let upper = |axis: usize| (i >> axis & 1) as i32;
            self.source(origin + IVec3::new(upper(0), upper(1), upper(2)) * LEAF_EDGE)
        })
    }

    /// The brick from `origin` on; `None` if it is 0 everywhere.
    fn brick(&self, origin: IVec3) -> Option<Brick> {
        let sources = self.sources(origin);
        if let VoxelSource::Constant(value) = sources[0]
            && sources
                .iter()
                .all(|source| matches!(source, VoxelSource::Constant(v) if *v == value))
        {
            return (value != 0.0).then(|| constant(origin, LEAF_EDGE, value));
        }
        let voxels = voxels(&sources);
        let first = voxels.bits()[0];
        let is_constant = voxels.bits().iter().all(|&bits| bits == first);
        match f16::from_bits(first).to_f32() {
            0.0 if is_constant => None,
            density if is_constant => Some(constant(origin, LEAF_EDGE, density)),
            _ => Some(Brick::new(origin, Density::Voxels(voxels))),
        }
    }
}

fn voxels(sources: &[VoxelSource<'_>; 8]) -> Voxels {
    Voxels::new(|voxel| {
        let upper = (voxel / LEAF_EDGE as u32).dot(UVec3::new(1, 2, 4));
        sources[upper as usize].at((voxel % LEAF_EDGE as u32).as_ivec3())
    })
}

fn constant(origin: IVec3, edge: i32, density: f32) -> Brick {
    Brick::new(origin, Density::Constant { size: UVec3::splat(edge as u32), density })
}

impl Tree {
    /// Bricks of all cells with a corner above 0, also of cells whose lowest corner is in no leaf.
    pub(crate) fn into_bricks(mut self) -> Result<Bricks, VolumeFault> {
        let (scale, [negative, not_finite]) = self.make_halves();
        let step = IVec3::splat(LEAF_EDGE);
        let mut origins = BTreeSet::new();
        let mut add = |origin: IVec3| {
            if origins.len() == MOST_NODES {
                let message = format!("its voxels need more than {MOST_NODES} bricks");
                return Err(VolumeFault::new(
                    message,
                    "resample it with larger voxels, or split it",
                ));
            }
            origins.insert(origin.to_array());
            Ok(())
        };
        let lower = |i: i32| IVec3::new(i & 1, i >> 1 & 1, i >> 2);
        for &leaf in &self.leaves {
            (0..8).try_for_each(|i| add(leaf - lower(i) * step))?;
        }
        let mut boxes = Vec::new();
        for &Tile { origin, edge, value } in &self.tiles {
            // A box holds all cells inside a tile except the last ones: their upper corners belong to
            // neighbours.
            if edge > LEAF_EDGE {
                boxes.push(constant(origin, edge - LEAF_EDGE, value));
            }
            let last = edge / LEAF_EDGE - 1;
            let is_rim = |i: i32| i < 0 || i == last;
            for x in -1..=last {
                for y in -1..=last {
                    if is_rim(x) || is_rim(y) {
                        (-1..=last).try_for_each(|z| add(origin + IVec3::new(x, y, z) * step))?;
                    } else {
                        add(origin + IVec3::new(x, y, -1) * step)?;
                        add(origin + IVec3::new(x, y, last) * step)?;
                    }
                }
            }
        }
        let bytes = origins.len() * size_of::<[u16; BRICK_VALUES]>();
        if !has_memory(bytes as u64) {
            let message = format!("no memory for {} bricks ({} MiB)", origins.len(), bytes >> 20);
            return Err(VolumeFault::new(
                message,
                "use a smaller grid, or a machine with more memory",
            ));
        }
        let lookup = VoxelSources::new(&self, 0.0);
        let made: Vec<_> =
            origins.into_par_iter().filter_map(|at| lookup.brick(IVec3::from(at))).collect();
        let (bricks, others): (Vec<_>, Vec<_>) =
            made.into_iter().partition(|brick| brick.voxels().is_some());
        boxes.extend(others);
        let mut bricks = bricks;
        bricks.extend(joined(boxes));
        Ok(Bricks { bricks, scale, negative, not_finite })
    }

    /// Gives bricks with voxels the tree's temperatures, `kelvin` for the value 1, clamped to the range of
    /// half floats. Returns the numbers of negative values and of values that are not finite; both count
    /// as 0.
    pub(crate) fn heat(mut self, bricks: &mut [Brick], kelvin: f32) -> [u64; 2] {
        let wrong = self.clear_wrong();
        for value in self.values_mut() {
            *value = (*value * kelvin).min(f16::MAX.to_f32());
        }
        let lookup = VoxelSources::new(&self, 0.0);
        for brick in bricks.iter_mut().filter(|brick| brick.voxels().is_some()) {
            let temperatures = voxels(&lookup.sources(brick.origin));
            let is_hot = temperatures.bits().iter().any(|&bits| bits != 0);
            brick.temperature = is_hot.then_some(temperatures);
        }
        wrong
    }

    /// Values of voxels, then of tiles.
    pub(crate) fn values_mut(&mut self) -> impl Iterator<Item = &mut f32> {
        self.values.iter_mut().chain(self.tiles.iter_mut().map(|tile| &mut tile.value))
    }

    /// Sets negative values and values that are not finite to 0; returns their numbers.
    fn clear_wrong(&mut self) -> [u64; 2] {
        let mut wrong = [0; 2];
        for value in self.values_mut().filter(|value| !value.is_finite() || **value < 0.0) {
            wrong[usize::from(!value.is_finite())] += 1;
            *value = 0.0;
        }
        wrong
    }

    /// Scales all values to densities that half floats can hold. Returns the density per value, and the
    /// numbers of negative values and of values that are not finite.
    fn make_halves(&mut self) -> (f32, [u64; 2]) {
        /// Densities up to here are as precise as larger ones.
        const LEAST: f32 = 1.0 / 64.0;
        let wrong = self.clear_wrong();
        let most = self.values_mut().fold(0f32, |most, value| most.max(*value));
        let fits = most == 0.0 || (LEAST..=65504.0).contains(&most);
        // A power of two changes only values that vanish beside the largest one.
        let scale = if fits { 1.0 } else { most.log2().floor().max(-120.0).exp2() };
        for value in self.values_mut() {
            *value = f16::from_f32(*value / scale).to_f32();
        }
        self.tiles.retain(|tile| tile.value != 0.0);
        (scale, wrong)
    }
}

/// Joins boxes of one density that share a face.
fn joined(mut boxes: Vec<Brick>) -> Vec<Brick> {
    let of = |brick: &Brick| match brick.density {
        Density::Constant { size, density } => (size, density),
        Density::Voxels(_) => unreachable!("boxes have one density"),
    };
    let mut count = usize::MAX;
    while boxes.len() < count {
        count = boxes.len();
        for axis in 0..3 {
            let [beside, behind] = [(axis + 1) % 3, (axis + 2) % 3];
            boxes.sort_unstable_by_key(|brick| {
                let (size, density) = of(brick);
                let sides = [beside, behind].map(|i| (brick.origin[i], size[i]));
                (density.to_bits(), sides, brick.origin[axis])
            });
            boxes.dedup_by(|next, brick| {
                let ((next_size, next_density), (size, density)) = (of(next), of(brick));
                let is_next =
                    |i: usize| next.origin[i] == brick.origin[i] && next_size[i] == size[i];
                let touches = brick.origin[axis] + size[axis] as i32 == next.origin[axis];
                let joins =
                    density == next_density && is_next(beside) && is_next(behind) && touches;
                if joins && let Density::Constant { size, .. } = &mut brick.density {
                    size[axis] += next_size[axis];
                }
                joins
            });
        }
    }
    boxes
}
