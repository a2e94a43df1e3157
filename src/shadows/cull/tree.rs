//! Bounding volume hierarchy of groups.
use super::frustum::{CROSSES_ALL, Frustum, widened};
use crate::model::Bounds;
use glam::{Vec3, Vec3A};
use obvhs::{
    aabb::Aabb,
    bvh2::Bvh2,
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};
use std::ops::Range;

/// Most groups of one leaf: testing that many boxes in a row costs less than traversing nodes for them.
const BLOCK: u32 = 8;

/// Nodes in preorder: the left child follows its parent, the right child follows the left one's subtree.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Lower corner of its box, world space \[m\].
    min: Vec3,
    /// Index just past the subtree.
    end: u32,
    max: Vec3,
    /// First of the subtree's groups, which are contiguous in [`GroupTree::groups`].
    first: u32,
}

/// Hierarchy of the groups' boxes, built by parallel locally-ordered clustering (Meister and Bittner 2018, by
/// the crate obvhs). That crate has no query by planes; this tree needs the groups of a subtree in one run,
/// so its nodes are laid out anew.
#[derive(Clone, Debug, Default)]
pub struct GroupTree {
    nodes: Vec<Node>,
    /// Groups in the order of the leaves.
    groups: Vec<u32>,
    /// Boxes of `groups`, world space \[m\].
    boxes: Vec<Bounds>,
    /// Groups with unbounded boxes: always visible.
    unbounded: Vec<u32>,
    group_count: usize,
    /// [`Self::size`] when the tree was built.
    built_size: u64,
}

/// Growth of boxes at which the tree is rebuilt, in units of [`typical_size`]: twice the surface.
const DEGRADED: u64 = DOUBLED;

impl GroupTree {
    /// Builds the tree over the boxes of all groups. An empty box has no contents and is never visible.
    pub fn new(bounds: &[Bounds]) -> Self {
        let mut tree = Self { group_count: bounds.len(), ..Self::default() };
        let (mut groups, mut boxes) = (Vec::new(), Vec::new());
        for (group, bounds) in (0..).zip(bounds) {
            match kind(bounds) {
                Boundedness::Empty => {}
                Boundedness::Unbounded => tree.unbounded.push(group),
                Boundedness::Bounded(Bounds { min, max }) => {
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
        let counts = leaf_counts(&bvh);
        // Nodes of `bvh` to be visited; within a block only its leaves are taken.
        let mut open = vec![(0, false)];
        while let Some((index, in_block)) = open.pop() {
            let node = &bvh.nodes[index as usize];
            let Aabb { min, max } = *node.aabb();
            let (min, max) = (min.into(), max.into());
            let is_block = counts[index as usize] <= BLOCK;
            if !in_block {
                let end = if is_block { 0 } else { UNKNOWN };
                tree.nodes.push(Node { min, end, max, first: tree.groups.len() as u32 });
            }
            if node.is_leaf() {
                let primitive = bvh.primitive_indices[node.first_index as usize];
                tree.groups.push(groups[primitive as usize]);
                tree.boxes.push(Bounds { min, max });
            } else {
                open.extend([(node.first_index + 1, is_block), (node.first_index, is_block)]);
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

    /// Refits the tree after groups have moved: new boxes, in the same number and order. Returns true if
    /// the tree was rebuilt.
    pub fn refit(&mut self, bounds: &[Bounds]) -> bool {
        if bounds.len() != self.group_count || !self.refit_nodes(bounds) {
            *self = Self::new(bounds);
            return true;
        }
        if self.size() > self.built_size + self.nodes.len() as u64 * DEGRADED {
            *self = Self::new(bounds);
            return true;
        }
        false
    }

    /// Refits the nodes; returns false if a group has lost or gained its bounds.
    fn refit_nodes(&mut self, bounds: &[Bounds]) -> bool {
        let is_bounded = |bounds: &&Bounds| matches!(kind(bounds), Boundedness::Bounded(_));
        let is_unbounded =
            |&group: &u32| matches!(kind(&bounds[group as usize]), Boundedness::Unbounded);
        if bounds.iter().filter(is_bounded).count() != self.groups.len()
            || !self.unbounded.iter().all(is_unbounded)
        {
            return false;
        }
        for (group, around) in self.groups.iter().zip(&mut self.boxes) {
            let Boundedness::Bounded(bounds) = kind(&bounds[*group as usize]) else { return false };
            *around = bounds;
        }
        for i in (0..self.nodes.len()).rev() {
            let node = self.nodes[i];
            let (min, max) = if node.end as usize == i + 1 {
                let boxes = &self.boxes[self.run(&node)];
                boxes.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(min, max), around| {
                    (min.min(around.min), max.max(around.max))
                })
            } else {
                let left = self.nodes[i + 1];
                let right = self.nodes[left.end as usize];
                (left.min.min(right.min), left.max.max(right.max))
            };
            (self.nodes[i].min, self.nodes[i].max) = (min, max);
        }
        true
    }

    /// The groups of a subtree, as a range of [`Self::groups`].
    fn run(&self, node: &Node) -> Range<usize> {
        let end = self.nodes.get(node.end as usize).map_or(self.groups.len() as u32, |n| n.first);
        node.first as usize..end as usize
    }

    /// Sum of [`typical_size`] over the boxes of all nodes.
    fn size(&self) -> u64 {
        typical_size(self.nodes.iter().map(|&Node { min, max, .. }| Bounds { min, max }))
    }

    /// Appends the groups that a view may see, each once, unsorted.
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
            if crossed == 0 {
                visible.extend_from_slice(&self.groups[self.run(node)]);
            } else if node.end == index + 1 {
                let run = self.run(node);
                for (&group, around) in self.groups[run.clone()].iter().zip(&self.boxes[run]) {
                    if frustum.cross(around.min, around.max, crossed).is_some() {
                        visible.push(group);
                    }
                }
            } else {
                open.push((self.nodes[index as usize + 1].end, crossed));
                open.push((index + 1, crossed));
            }
        }
    }
}

/// Number of leaves below each node of `bvh`.
fn leaf_counts(bvh: &Bvh2) -> Vec<u32> {
    let mut order = vec![0];
    let mut next = 0;
    while let Some(&index) = order.get(next) {
        let node = &bvh.nodes[index as usize];
        if !node.is_leaf() {
            order.extend([node.first_index, node.first_index + 1]);
        }
        next += 1;
    }
    let mut counts = vec![1; bvh.nodes.len()];
    for &index in order.iter().rev() {
        let node = &bvh.nodes[index as usize];
        if !node.is_leaf() {
            let first = node.first_index as usize;
            counts[index as usize] = counts[first] + counts[first + 1];
        }
    }
    counts
}

/// Typical size of boxes: the sum of the logarithms of their surfaces, times 2^23. Unlike in a sum of
/// surfaces, one box that outgrows all others does not mask the rest.
pub fn typical_size(boxes: impl Iterator<Item = Bounds>) -> u64 {
    // The bits of a positive f32 are nearly its logarithm.
    boxes.map(|bounds| u64::from(bounds.half_area().max(0.0).to_bits())).sum()
}

/// Increase of [`typical_size`] by a box of twice the surface.
pub const DOUBLED: u64 = 1 << 23;

enum Boundedness {
    Empty,
    Unbounded,
    Bounded(Bounds),
}

fn kind(bounds: &Bounds) -> Boundedness {
    // A box with a NaN is not empty: it has contents.
    if bounds.min.cmpgt(bounds.max).any() && !bounds.min.is_nan() && !bounds.max.is_nan() {
        return Boundedness::Empty;
    }
    widened(bounds).map_or(Boundedness::Unbounded, Boundedness::Bounded)
}
