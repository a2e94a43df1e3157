//! The nodes of a `NanoVDB` grid. Each stores its children's offsets from itself \[bytes\].
use super::{
    input::{Input, VolumeFault},
    nano::GRID,
    tree::{
        FARTHEST, LEAF_EDGE, LEAF_VOXELS, LOWER_EDGE, MOST_NODES, Tile, Tree, UPPER_EDGE, too_many,
    },
    values::is_set,
};
use glam::IVec3;
use half::f16;
use std::collections::HashSet;

/// Storage type of a grid's numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NanoType {
    Float,
    Double,
    Int16,
    Int32,
    Half,
    /// Values are quantised to this many bits between each leaf's least and largest value.
    Steps(u8),
    /// The same, with a number of bits that each leaf states.
    AnySteps,
}

/// Offsets of the parts of a grid's nodes \[bytes\].
struct Offsets {
    background: usize,
    root: usize,
    /// Value of an entry of the root.
    tile: usize,
    leaf: usize,
}

/// Size of an entry of the root; of an upper and a lower node up to their tables of children; and of a
/// table's entry \[bytes\].
const TILE: usize = 32;
const UPPER: usize = 8256;
const LOWER: usize = 1088;
const ENTRY: usize = 8;

impl NanoType {
    pub(super) fn of(number: u32) -> Option<Self> {
        Some(match number {
            1 => Self::Float,
            2 => Self::Double,
            3 => Self::Int16,
            4 => Self::Int32,
            9 => Self::Half,
            13 => Self::Steps(4),
            14 => Self::Steps(8),
            15 => Self::Steps(16),
            16 => Self::AnySteps,
            _ => return None,
        })
    }

    fn offsets(self) -> Offsets {
        match self {
            Self::Double => Offsets { background: 32, root: 96, tile: 24, leaf: 128 },
            _ => Offsets { background: 28, root: 64, tile: 20, leaf: 96 },
        }
    }

    /// The value at byte `at`.
    fn value(self, bytes: &[u8], at: usize) -> Result<f32, VolumeFault> {
        const WHAT: &str = "a value";
        let mut input = Input::new(bytes, at)?;
        let mut two = || Ok(input.take(2, WHAT)?.try_into().unwrap_or_default());
        Ok(match self {
            Self::Double => input.f64(WHAT)? as f32,
            Self::Int16 => f32::from(i16::from_le_bytes(two()?)),
            Self::Half => f16::from_le_bytes(two()?).to_f32(),
            Self::Int32 => input.u32(WHAT)?.cast_signed() as f32,
            Self::Float | Self::Steps(_) | Self::AnySteps => f32::from_bits(input.u32(WHAT)?),
        })
    }

    /// Size of a value in a leaf without quantisation \[bytes\].
    fn size(self) -> usize {
        match self {
            Self::Double => 8,
            Self::Int16 | Self::Half => 2,
            _ => 4,
        }
    }
}

/// The tree of a grid, and the value of voxels outside it.
pub(super) fn tree(
    grid: &[u8],
    kind: NanoType,
    has_values: bool,
) -> Result<(Tree, f32), VolumeFault> {
    let mut nodes = NanoNodes { grid, kind, background: 0.0, left: [0; 3], tree: Tree::default() };
    // Nodes of each level occupy bytes of their own: a longer list holds copies, and might never end.
    nodes.left = [UPPER, LOWER, 96].map(|size| grid.len() / size + 1);
    let long = |at: usize| Input::new(grid, at)?.i64("the place of the root");
    let root = child(GRID, long(GRID + 24)?)?;
    nodes.root(root, has_values)?;
    Ok((nodes.tree, nodes.background))
}

/// The position `offset` bytes away.
fn child(from: usize, offset: i64) -> Result<usize, VolumeFault> {
    let at = i64::try_from(from).ok().and_then(|from| from.checked_add(offset));
    at.and_then(|at| usize::try_from(at).ok())
        .ok_or_else(|| VolumeFault::damaged("a node is outside of the grid"))
}

struct NanoNodes<'a> {
    grid: &'a [u8],
    kind: NanoType,
    background: f32,
    /// Upper nodes, lower nodes and leaves that may still follow.
    left: [usize; 3],
    tree: Tree,
}

impl NanoNodes<'_> {
    fn root(&mut self, root: usize, has_values: bool) -> Result<(), VolumeFault> {
        const WHAT: &str = "the root";
        let offsets = self.kind.offsets();
        self.background = self.kind.value(self.grid, root.saturating_add(offsets.background))?;
        let count = Input::new(self.grid, root.saturating_add(24))?.u32(WHAT)? as usize;
        let start = root + offsets.root;
        Input::new(self.grid, start)?.take(count.saturating_mul(TILE), "the table of the root")?;
        let mut known = HashSet::new();
        for i in 0..count {
            let at = start + i * TILE;
            let mut input = Input::new(self.grid, at)?;
            let (key, offset) = (input.i64(WHAT)?, input.i64(WHAT)?);
            let is_active = input.u32(WHAT)? != 0;
            // Three numbers of 21 bits, 20 of them significant: coordinates without their last 12 bits.
            let part = |shift: u32| ((key >> shift) as i32) << 12;
            let origin = IVec3::new(part(42), part(21), part(0));
            let is_near = origin.cmpge(IVec3::splat(-FARTHEST)).all()
                && origin.cmple(IVec3::splat(FARTHEST)).all();
            if !is_near || !known.insert(origin) {
                return Err(VolumeFault::damaged(format!(
                    "a node at {origin} is too far, or there twice"
                )));
            }
            if offset == 0 {
                let value = self.kind.value(self.grid, at + offsets.tile)?;
                self.tile(Tile { origin, edge: UPPER_EDGE, value }, is_active)?;
            } else {
                let upper = child(root, offset)?;
                for (lower, origin) in self.inner::<5>(upper, UPPER, origin, LOWER_EDGE)? {
                    for (leaf, origin) in self.inner::<4>(lower, LOWER, origin, LEAF_EDGE)? {
                        self.leaf(leaf, origin, has_values)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Counts a node of a level.
    fn count(&mut self, level: usize) -> Result<(), VolumeFault> {
        let left = self.left[level].checked_sub(1);
        self.left[level] =
            left.ok_or_else(|| VolumeFault::damaged("the same node is there many times"))?;
        Ok(())
    }

    /// Adds the tiles of an inner node with 2^LOG parts along each edge; returns the positions and origins of
    /// its children.
    fn inner<const LOG: usize>(
        &mut self,
        node: usize,
        table: usize,
        origin: IVec3,
        edge: i32,
    ) -> Result<Vec<(usize, IVec3)>, VolumeFault> {
        const MASKS: usize = 32;
        self.count(if LOG == 5 { 0 } else { 1 })?;
        let count = 1 << (3 * LOG);
        let mut input = Input::new(self.grid, node.saturating_add(MASKS))?;
        let active = input.take(count / 8, "the mask of a node")?;
        let children = input.take(count / 8, "the mask of a node")?;
        Input::new(self.grid, node + table)?.take(count * ENTRY, "the table of a node")?;
        let part = |i: usize, shift: usize| (i >> shift & ((1 << LOG) - 1)) as i32;
        let mut found = Vec::new();
        for i in 0..count {
            let at = node + table + i * ENTRY;
            let origin = origin + IVec3::new(part(i, 2 * LOG), part(i, LOG), part(i, 0)) * edge;
            if is_set(children, i) {
                let offset = Input::new(self.grid, at)?.i64("the place of a node")?;
                found.push((child(node, offset)?, origin));
            } else {
                let value = self.kind.value(self.grid, at)?;
                self.tile(Tile { origin, edge, value }, is_set(active, i))?;
            }
        }
        Ok(found)
    }

    fn tile(&mut self, tile: Tile, is_active: bool) -> Result<(), VolumeFault> {
        self.tree.active += u64::from(is_active) * (i64::from(tile.edge).pow(3) as u64);
        if tile.value == 0.0 || !is_active && tile.value == self.background {
            return Ok(());
        }
        if self.tree.tiles.len() == MOST_NODES {
            return Err(too_many("tiles"));
        }
        self.tree.tiles.push(tile);
        Ok(())
    }

    fn leaf(&mut self, leaf: usize, origin: IVec3, has_values: bool) -> Result<(), VolumeFault> {
        const WHAT: &str = "a leaf";
        self.count(2)?;
        if self.tree.leaves.len() == MOST_NODES {
            return Err(too_many("leaves"));
        }
        let table = self.kind.offsets().leaf;
        let head = Input::new(self.grid, leaf)?.take(table, WHAT)?;
        self.tree.leaves.push(origin);
        if !has_values {
            return Ok(());
        }
        let active = &head[16..80];
        let bits = match self.kind {
            NanoType::Steps(bits) => Some(usize::from(bits)),
            // The upper three bits of the flags are the logarithm.
            NanoType::AnySteps => Some(1_usize << (head[15] >> 5)).filter(|&bits| bits <= 16),
            _ => None,
        };
        if bits.is_none() && self.kind == NanoType::AnySteps {
            return Err(VolumeFault::damaged("a leaf has steps of more than 16 bits"));
        }
        let length = bits.map_or(self.kind.size() * LEAF_VOXELS, |bits| bits * LEAF_VOXELS / 8);
        let mut input = Input::new(self.grid, leaf + table)?;
        let stored = input.take(length, WHAT)?;
        let number = |at: usize| self.kind.value(head, at);
        let [least, step] = match bits {
            Some(_) => [number(80)?, number(84)?],
            None => [0.0; 2],
        };
        for i in 0..LEAF_VOXELS {
            let value = match bits {
                Some(bits) => least + step * steps(stored, bits, i),
                None => self.kind.value(stored, i * self.kind.size())?,
            };
            // With quantisation the background is rarely among the values.
            let is_nothing = !is_set(active, i) && (bits.is_some() || value == self.background);
            self.tree.values.push(if is_nothing { 0.0 } else { value });
            self.tree.active += u64::from(is_set(active, i));
        }
        Ok(())
    }
}

/// Quantised value of a voxel: 1 to 16 bits, lowest voxel first.
fn steps(stored: &[u8], bits: usize, i: usize) -> f32 {
    let place = i * bits;
    let byte = u16::from(stored[place / 8]);
    if bits == 16 {
        return f32::from(byte | u16::from(stored[place / 8 + 1]) << 8);
    }
    f32::from(byte >> (place % 8) & ((1 << bits) - 1))
}
