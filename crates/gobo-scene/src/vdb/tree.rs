//! Values of a grid's tree: leaves of 8^3 voxels, and tiles of one value.
use super::{
    input::{Input, VolumeFault},
    values::{Encoding, MOST_VALUES, NODE_MASKS, Scratch, count_set, is_set, mask_bytes},
};
use glam::IVec3;
use gobo::model::MAX_INDEX;
use std::collections::HashSet;

/// Edge of a leaf \[voxels\].
pub(crate) const LEAF_EDGE: i32 = 8;
/// Voxels of a leaf.
pub(crate) const LEAF_VOXELS: usize = 512;
/// Edges of the tiles of the upper nodes \[voxels\].
pub(super) const LOWER_EDGE: i32 = 128;
pub(crate) const UPPER_EDGE: i32 = 4096;
/// Farthest origin of a root entry that is read.
pub(super) const FARTHEST: i32 = MAX_INDEX - UPPER_EDGE;

/// A box of voxels of one value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tile {
    /// Lowest voxel, index space.
    pub(crate) origin: IVec3,
    /// Edge: 8, 128 or 4096 \[voxels\].
    pub(crate) edge: i32,
    pub(crate) value: f32,
}

/// The voxels of a grid. Unset voxels, and inactive ones with the background's value, are 0; in a colour
/// channel they have the background's value.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    /// Lowest voxels of the leaves, index space.
    pub(crate) leaves: Vec<IVec3>,
    /// 512 values for each leaf, z first.
    pub(crate) values: Vec<f32>,
    /// Tiles whose value differs from that of unset voxels.
    pub(crate) tiles: Vec<Tile>,
    /// Active voxels of leaves and tiles.
    pub(crate) active: u64,
}

/// Most leaves, tiles with a value, and bricks of a grid: a brick has 1.5 KB.
pub(crate) const MOST_NODES: usize = 1 << 19;

/// Reader of a tree's nodes, and of its inner nodes' values.
pub(super) struct Topology<'a, 'b> {
    pub(super) input: &'b mut Input<'a>,
    pub(super) encoding: &'b mut Encoding,
    pub(super) scratch: Scratch,
    pub(super) tree: Tree,
}

impl Topology<'_, '_> {
    pub(super) fn read(mut self) -> Result<Tree, VolumeFault> {
        self.input.u32("the number of buffers")?;
        self.encoding.background = self.encoding.single(self.input, "the background")?;
        let tiles = self.input.u32("the number of tiles")?;
        let nodes = self.input.u32("the number of nodes")?;
        let mut known = HashSet::new();
        for _ in 0..tiles {
            let origin = self.root_entry(&mut known)?;
            let value = self.encoding.single(self.input, "the value of a tile")?;
            let is_active = self.input.u8("the state of a tile")? != 0;
            self.tile(Tile { origin, edge: UPPER_EDGE, value }, is_active)?;
        }
        let mut values = vec![0.0; MOST_VALUES];
        for _ in 0..nodes {
            let origin = self.root_entry(&mut known)?;
            self.upper(origin, &mut values)?;
        }
        Ok(self.tree)
    }

    /// Origin of a root entry, which must be unique.
    fn root_entry(&mut self, known: &mut HashSet<IVec3>) -> Result<IVec3, VolumeFault> {
        let at = self.input.at();
        let origin = self.input.ivec3("the origin of a node")?;
        let is_near = origin.cmpge(IVec3::splat(-FARTHEST)).all()
            && origin.cmple(IVec3::splat(FARTHEST)).all();
        if !is_near || origin % UPPER_EDGE != IVec3::ZERO || !known.insert(origin) {
            let why = match () {
                () if !is_near => "too far from 0: origins are at most 4190208",
                () if origin % UPPER_EDGE != IVec3::ZERO => "not at a multiple of 4096 voxels",
                () => "there twice",
            };
            return Err(VolumeFault::damaged(format!("the node {origin} at byte {at} is {why}")));
        }
        Ok(origin)
    }

    /// Reads a node of 32^3 parts and everything below it.
    fn upper(&mut self, origin: IVec3, values: &mut [f32]) -> Result<(), VolumeFault> {
        let children = self.inner::<5>(origin, LOWER_EDGE, values)?;
        for origin in children {
            let leaves = self.inner::<4>(origin, LEAF_EDGE, values)?;
            for origin in leaves {
                if self.tree.leaves.len() == MOST_NODES {
                    return Err(too_many("leaves"));
                }
                self.input.take(mask_bytes(LEAF_VOXELS), "the mask of a leaf")?;
                self.tree.leaves.push(origin);
            }
        }
        Ok(())
    }

    /// Adds the tiles of an inner node with 2^LOG parts along each edge; returns the origins of its children.
    fn inner<const LOG: usize>(
        &mut self,
        origin: IVec3,
        edge: i32,
        values: &mut [f32],
    ) -> Result<Vec<IVec3>, VolumeFault> {
        let count = 1 << (3 * LOG);
        let children = self.input.take(mask_bytes(count), "the mask of an inner node")?;
        let active = self.input.take(mask_bytes(count), "the mask of an inner node")?;
        let origin_of = |i: usize| {
            let part = |shift: usize| (i >> shift & ((1 << LOG) - 1)) as i32;
            origin + IVec3::new(part(2 * LOG), part(LOG), part(0)) * edge
        };
        // Older versions leave out children's values.
        let has_all = self.encoding.version >= NODE_MASKS;
        let stored = if has_all { count } else { count - count_set(children) };
        let values = &mut values[..stored];
        self.encoding.read(self.input, active, values, &mut self.scratch)?;
        let mut parts = (0..count).filter(|&i| has_all || !is_set(children, i));
        for &mut value in values {
            let i = parts.next().unwrap_or_default();
            if !is_set(children, i) {
                self.tile(Tile { origin: origin_of(i), edge, value }, is_set(active, i))?;
            }
        }
        Ok((0..count).filter(|&i| is_set(children, i)).map(origin_of).collect())
    }

    fn tile(&mut self, tile: Tile, is_active: bool) -> Result<(), VolumeFault> {
        self.tree.active += u64::from(is_active) * (i64::from(tile.edge).pow(3) as u64);
        let is_unset = tile.value == self.encoding.unset();
        if is_unset || !is_active && tile.value == self.encoding.background {
            return Ok(());
        }
        if self.tree.tiles.len() == MOST_NODES {
            return Err(too_many("tiles"));
        }
        self.tree.tiles.push(tile);
        Ok(())
    }
}

impl Tree {
    /// Reads the values of the leaves, which follow all nodes.
    pub(super) fn read_leaves(
        &mut self,
        input: &mut Input<'_>,
        encoding: &Encoding,
    ) -> Result<(), VolumeFault> {
        let length = self.leaves.len() * LEAF_VOXELS;
        self.values.try_reserve_exact(length).map_err(|_| {
            let message = format!("no memory for {} leaves", self.leaves.len());
            VolumeFault::new(message, "use a smaller grid, or a machine with more memory")
        })?;
        self.values.resize(length, 0.0);
        let mut scratch = Scratch::default();
        for values in self.values.chunks_exact_mut(LEAF_VOXELS) {
            let active = input.take(mask_bytes(LEAF_VOXELS), "the mask of a leaf")?;
            let mut buffers = 1;
            if encoding.version < NODE_MASKS {
                input.ivec3("the origin of a leaf")?;
                buffers = input.u8("the number of a leaf's buffers")?;
            }
            encoding.read(input, active, values, &mut scratch)?;
            for _ in 1..buffers {
                encoding.skip(input, LEAF_VOXELS, &mut scratch)?;
            }
            self.active += count_set(active) as u64;
            for (i, value) in values.iter_mut().enumerate() {
                if *value == encoding.background && !is_set(active, i) {
                    *value = encoding.unset();
                }
            }
        }
        Ok(())
    }
}

pub(super) fn too_many(what: &str) -> VolumeFault {
    let message = format!("the grid has more than {MOST_NODES} {what}");
    VolumeFault::new(message, "resample it with larger voxels, or split it")
}
