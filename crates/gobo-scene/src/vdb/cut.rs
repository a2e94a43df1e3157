//! Clipping of a tree: voxels outside become 0.
use super::{
    input::VolumeFault,
    tree::{LEAF_EDGE, LEAF_VOXELS, LOWER_EDGE, MOST_NODES, Tile, Tree, too_many},
};
use glam::IVec3;

impl Tree {
    /// Keeps the voxels for which `has` is true. `has_all` answers for a box of voxels, given by its first
    /// and last: all, none, or unknown; tiles with an unknown answer are split.
    pub(crate) fn cut(
        mut self,
        has: impl Fn(IVec3) -> bool,
        has_all: impl Fn(IVec3, IVec3) -> Option<bool>,
    ) -> Result<Self, VolumeFault> {
        let voxel = |i: usize| IVec3::new(i as i32 / 64, i as i32 / 8 % 8, i as i32 % 8);
        for (&origin, values) in self.leaves.iter().zip(self.values.chunks_exact_mut(LEAF_VOXELS)) {
            for (i, value) in values.iter_mut().enumerate() {
                if !has(origin + voxel(i)) {
                    *value = 0.0;
                }
            }
        }
        let mut open = std::mem::take(&mut self.tiles);
        while let Some(Tile { origin, edge, value }) = open.pop() {
            match has_all(origin, origin + edge - 1) {
                Some(false) => continue,
                Some(true) => self.tiles.push(Tile { origin, edge, value }),
                None if edge == LEAF_EDGE => {
                    self.leaves.push(origin);
                    let cut = |i| if has(origin + voxel(i)) { value } else { 0.0 };
                    self.values.extend((0..LEAF_VOXELS).map(cut));
                }
                None => {
                    let step = if edge == LOWER_EDGE { LEAF_EDGE } else { LOWER_EDGE };
                    let parts = edge / step;
                    let part =
                        |i: i32| IVec3::new(i / (parts * parts), i / parts % parts, i % parts);
                    let origin = |i| origin + part(i) * step;
                    open.extend((0..parts.pow(3)).map(|i| Tile {
                        origin: origin(i),
                        edge: step,
                        value,
                    }));
                }
            }
            if self.leaves.len().max(self.tiles.len()).max(open.len()) > MOST_NODES {
                return Err(too_many("leaves and tiles"));
            }
        }
        Ok(self)
    }
}
