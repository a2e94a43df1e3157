//! A tree of boxes.
use super::frustum::{CROSSES_ALL, Frustum, widened};
use crate::scene::Bounds;
use glam::{Vec3, Vec3A};
use obvhs::{
    aabb::Aabb,
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};

/// In preorder: the left child follows its parent, the right child follows the left one's subtree.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// World space [m].
    min: Vec3,
    /// Just past the subtree. It has `n` leaves and `2n - 1` nodes.
    end: u32,
    max: Vec3,
    /// The first of the subtree's leaves, which lie side by side in [`GroupTree::leaves`].
    first_leaf: u32,
}

/// Boxes of groups, by place: built by parallel locally-ordered clustering (Meister and Bittner
/// 2018, by the crate obvhs), which has no query for planes; ours needs the leaves of a subtree in
/// one run, so its nodes are laid out anew.
#[derive(Clone, Debug, Default)]
pub struct GroupTree {
    nodes: Vec<Node>,
    /// Groups in order of the leaves.
    leaves: Vec<u32>,
    /// Groups whose boxes cannot be judged: always seen.
    unbounded: Vec<u32>,
    group_count: usize,
    /// [`Self::size`] when it was built.
    built_size: u64,
}

/// How much larger boxes may become before the tree is built anew, in units of
/// [`typical_size`]: twice the surface.
const DEGRADED: u64 = DOUBLED;

impl GroupTree {
    /// Over the boxes of all groups. An empty box has nothing in it and is never seen.
    pub fn new(bounds: &[Bounds]) -> Self {
        let mut tree = Self { group_count: bounds.len(), ..Self::default() };
        let (mut groups, mut boxes) = (Vec::new(), Vec::new());
        for (group, bounds) in (0..).zip(bounds) {
            match kind(bounds) {
                Kind::Empty => {}
                Kind::Unbounded => tree.unbounded.push(group),
                Kind::Bounded(Bounds { min, max }) => {
                    groups.push(group);
                    boxes.push(Aabb::new(Vec3A::from(min), Vec3A::from(max)));
                }
            }
        }
        if groups.is_empty() {
            return tree;
        }
        let indices = (0..groups.len() as u32).collect();
        let bvh = PlocBuilder::with_capacity(groups.len()).build(
            PlocSearchDistance::Low,
            &boxes,
            indices,
            SortPrecision::U64,
            0,
        );
        const UNKNOWN: u32 = u32::MAX;
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            let node = &bvh.nodes[index as usize];
            let (Aabb { min, max }, is_leaf) = (*node.aabb(), node.is_leaf());
            tree.nodes.push(Node {
                min: min.into(),
                end: if is_leaf { 0 } else { UNKNOWN },
                max: max.into(),
                first_leaf: tree.leaves.len() as u32,
            });
            if is_leaf {
                let primitive = bvh.primitive_indices[node.first_index as usize];
                tree.leaves.push(groups[primitive as usize]);
            } else {
                open.extend([node.first_index + 1, node.first_index]);
            }
        }
        for i in (0..tree.nodes.len()).rev() {
            tree.nodes[i].end = if tree.nodes[i].end == UNKNOWN {
                let right = tree.nodes[i + 1].end;
                tree.nodes[right as usize].end
            } else {
                i as u32 + 1
            };
        }
        tree.built_size = tree.size();
        tree
    }

    /// After groups have moved: their boxes anew, in the same number and order. True where the
    /// tree had to be built anew.
    pub fn refit(&mut self, bounds: &[Bounds]) -> bool {
        if bounds.len() != self.group_count || !self.refit_nodes(bounds) {
            *self = Self::new(bounds);
            return true;
        }
        let inner = (self.nodes.len() / 2) as u64;
        if self.size() > self.built_size + inner * DEGRADED {
            *self = Self::new(bounds);
            return true;
        }
        false
    }

    /// False where a group has lost or found its bounds.
    fn refit_nodes(&mut self, bounds: &[Bounds]) -> bool {
        let is_bounded = |bounds: &&Bounds| matches!(kind(bounds), Kind::Bounded(_));
        let is_unbounded = |&group: &u32| matches!(kind(&bounds[group as usize]), Kind::Unbounded);
        if bounds.iter().filter(is_bounded).count() != self.leaves.len()
            || !self.unbounded.iter().all(is_unbounded)
        {
            return false;
        }
        for i in (0..self.nodes.len()).rev() {
            let node = self.nodes[i];
            let (min, max) = if node.end as usize == i + 1 {
                let group = self.leaves[node.first_leaf as usize];
                let Kind::Bounded(Bounds { min, max }) = kind(&bounds[group as usize]) else {
                    return false;
                };
                (min, max)
            } else {
                let left = self.nodes[i + 1];
                let right = self.nodes[left.end as usize];
                (left.min.min(right.min), left.max.max(right.max))
            };
            (self.nodes[i].min, self.nodes[i].max) = (min, max);
        }
        true
    }

    /// Of the inner boxes.
    fn size(&self) -> u64 {
        let is_inner = |(i, node): &(usize, &Node)| node.end as usize != i + 1;
        let inner = self.nodes.iter().enumerate().filter(is_inner);
        typical_size(inner.map(|(_, &Node { min, max, .. })| Bounds { min, max }))
    }

    /// Appends the groups that a view may see, each once, in no useful order.
    pub fn cull(&self, frustum: &Frustum, visible: &mut Vec<u32>) {
        visible.extend_from_slice(&self.unbounded);
        if self.nodes.is_empty() {
            return;
        }
        let mut open = Vec::with_capacity(64);
        open.push((0, CROSSES_ALL));
        while let Some((index, planes)) = open.pop() {
            let node = &self.nodes[index as usize];
            let Some(crossed) = frustum.cross(node.min, node.max, planes) else { continue };
            let is_leaf = node.end == index + 1;
            if crossed == 0 || is_leaf {
                let first = node.first_leaf as usize;
                let count = (node.end - index).div_ceil(2) as usize;
                visible.extend_from_slice(&self.leaves[first..first + count]);
            } else {
                open.push((self.nodes[index as usize + 1].end, crossed));
                open.push((index + 1, crossed));
            }
        }
    }
}

/// How large boxes are on the whole: the sum of the logarithms of their surfaces, times 2^23.
/// Unlike a sum of surfaces, one box that grows beyond all others hides nothing.
pub fn typical_size(boxes: impl Iterator<Item = Bounds>) -> u64 {
    // The bits of a positive f32 are its logarithm, nearly.
    boxes.map(|bounds| u64::from(bounds.half_area().max(0.0).to_bits())).sum()
}

/// What a box of twice the surface adds to [`typical_size`].
pub const DOUBLED: u64 = 1 << 23;

enum Kind {
    Empty,
    Unbounded,
    Bounded(Bounds),
}

fn kind(bounds: &Bounds) -> Kind {
    // A box with a NaN is no empty one: something is in it.
    if bounds.min.cmpgt(bounds.max).any() && !bounds.min.is_nan() && !bounds.max.is_nan() {
        return Kind::Empty;
    }
    widened(bounds).map_or(Kind::Unbounded, Kind::Bounded)
}
