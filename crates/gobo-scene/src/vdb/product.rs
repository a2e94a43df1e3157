//! The product of two grids, voxel by voxel.
use super::{
    bricks::{VoxelSource, VoxelSources},
    input::VolumeFault,
    tree::{LEAF_EDGE, LEAF_VOXELS, LOWER_EDGE, MOST_NODES, Tile, Tree, too_many},
};
use glam::IVec3;
use std::collections::HashSet;

impl Tree {
    /// The product with another grid, whose voxels are `unset` where it has none. Tiles in which the other
    /// grid varies are split.
    pub(crate) fn times(self, other: &Self, unset: f32) -> Result<Self, VolumeFault> {
        let lookup = VoxelSources::new(other, unset);
        let small = other.tiles.iter().filter(|tile| tile.edge < LOWER_EDGE);
        let nodes = other.leaves.iter().copied().chain(small.map(|tile| tile.origin));
        let changing: HashSet<IVec3> =
            nodes.map(|origin| origin.div_euclid(IVec3::splat(LOWER_EDGE)) * LOWER_EDGE).collect();
        let mut product = Self { active: self.active, ..Self::default() };
        for (&origin, values) in self.leaves.iter().zip(self.values.chunks_exact(LEAF_VOXELS)) {
            product.add(origin, |i| values[i], lookup.source(origin))?;
        }
        for Tile { origin, edge, value } in self.tiles {
            if edge > LOWER_EDGE {
                // The tile alone exceeds the limit of bricks, whatever its colours.
                product.add_tile(Tile { origin, edge, value })?;
                continue;
            }
            if edge == LOWER_EDGE && !changing.contains(&origin) {
                if let VoxelSource::Constant(factor) = lookup.source(origin) {
                    product.add_tile(Tile { origin, edge, value: value * factor })?;
                }
                continue;
            }
            let parts = edge / LEAF_EDGE;
            for i in 0..parts.pow(3) {
                let leaf = IVec3::new(i / (parts * parts), i / parts % parts, i % parts);
                let origin = origin + leaf * LEAF_EDGE;
                match lookup.source(origin) {
                    VoxelSource::Constant(factor) => {
                        product.add_tile(Tile {
                            origin,
                            edge: LEAF_EDGE,
                            value: value * factor,
                        })?;
                    }
                    source @ VoxelSource::Leaf(_) => product.add(origin, |_| value, source)?,
                }
            }
        }
        Ok(product)
    }

    /// Adds a leaf of `values`, z first, times the voxels of a source.
    fn add(
        &mut self,
        origin: IVec3,
        values: impl Fn(usize) -> f32,
        source: VoxelSource<'_>,
    ) -> Result<(), VolumeFault> {
        if self.leaves.len() == MOST_NODES {
            return Err(too_many("leaves"));
        }
        self.leaves.push(origin);
        let voxel = |i: usize| IVec3::new(i as i32 / 64, i as i32 / 8 % 8, i as i32 % 8);
        self.values.extend((0..LEAF_VOXELS).map(|i| values(i) * source.at(voxel(i))));
        Ok(())
    }

    fn add_tile(&mut self, tile: Tile) -> Result<(), VolumeFault> {
        if self.tiles.len() == MOST_NODES {
            return Err(too_many("tiles"));
        }
        if tile.value != 0.0 {
            self.tiles.push(tile);
        }
        Ok(())
    }
}
