//! Nodes as they are stored in maps. CPU reference of `wgsl/curve/{node,stored,loaded,light}.wgsl`.
//!
//! A node stores what it passes by itself, so that light at a depth is the product of the nodes in any order.
use super::{DEPTHS, EVEN, LEAST, LEVELS, OCTAVE};
use crate::{
    records::{CurveMap, PackedNode},
    reference::resolve::BLACK,
};
use glam::{BVec3, Vec3};

fn stored_channel(passed: f32, grows: bool) -> u32 {
    if grows {
        let level = passed.max(1e-9).log2() * OCTAVE + EVEN;
        return if passed > 0.0 { level.clamp(1.0, LEVELS).round_ties_even() as u32 } else { 0 };
    }
    (passed.clamp(0.0, 1.0) * LEVELS).round_ties_even() as u32
}

fn loaded_channel(bits: u32, grows: bool) -> f32 {
    match (grows, bits) {
        (true, 0) => 0.0,
        (true, _) => ((bits as f32 - EVEN) / OCTAVE).exp2(),
        (false, _) => bits as f32 / LEVELS,
    }
}

/// Packs `start` and `length` in fixed point, and what the node passes.
pub(in crate::reference) fn packed(
    start: u32,
    length: f32,
    passed: Vec3,
    grows: bool,
) -> PackedNode {
    let root = ((length.max(0.0) / DEPTHS).sqrt() * LEVELS).round_ties_even() as u32;
    let stored = |v| stored_channel(v, grows);
    let (r, g, b) = (stored(passed.x), stored(passed.y), stored(passed.z));
    [start << 16 | root << 4 | r >> 8, (r & 255) << 24 | g << 12 | b]
}

/// Start and length in fixed point, and what the node passes.
pub(in crate::reference) fn unpack([first, second]: PackedNode, grows: bool) -> (f32, f32, Vec3) {
    let root = (first >> 4 & 0xfff) as f32 / LEVELS;
    let loaded = |v| loaded_channel(v, grows);
    let red = (first & 15) << 8 | second >> 24;
    let passed = Vec3::new(loaded(red), loaded(second >> 12 & 0xfff), loaded(second & 0xfff));
    ((first >> 16) as f32, root * root * DEPTHS, passed)
}

/// Stores nodes of which the light behind each is known, in order: what rounding takes, the next node gives back.
#[derive(Clone, Copy, Debug)]
pub(in crate::reference) struct Storing {
    /// Light behind the nodes that were stored.
    left: Vec3,
    grows: bool,
}

impl Storing {
    pub(in crate::reference) const fn new(grows: bool) -> Self {
        Self { left: Vec3::ONE, grows }
    }

    /// Node from `start`, in fixed point, behind which `light` is left. `start` 0: an unused one, which passes all.
    pub(in crate::reference) fn store(
        &mut self,
        start: u32,
        length: f32,
        light: Vec3,
    ) -> PackedNode {
        let passed = light / self.left.max(Vec3::splat(1e-9));
        let dark = light.cmplt(Vec3::splat(BLACK)) & BVec3::splat(!self.grows);
        let passed = if start > 0 { Vec3::select(dark, Vec3::ZERO, passed) } else { Vec3::ONE };
        let node = packed(start, length, passed, self.grows);
        self.left *= unpack(node, self.grows).2;
        node
    }
}

/// Light behind nodes that can be stored. Where a late hit brightened what is behind it, the nodes before it are too
/// dark; where light grows from black, they keep the least from which it can.
pub(super) fn storable(light: &mut [Vec3], grows: bool) {
    let least = if grows { LEAST } else { 1.0 };
    let mut rest = Vec3::ZERO;
    for light in light.iter_mut().rev() {
        let own = Vec3::select(light.cmplt(Vec3::splat(BLACK)), Vec3::ZERO, *light);
        *light = own.max(rest * least);
        rest = rest.max(*light);
    }
}

/// Light at light depth `z` of a curve; `grows` as it was packed. The order of the nodes changes nothing.
pub fn light_at(nodes: &[PackedNode], z: f32, grows: bool) -> Vec3 {
    let z = z * DEPTHS;
    nodes.iter().fold(Vec3::ONE, |light, &node| {
        let (start, length, passed) = unpack(node, grows);
        let share = ((z - start) / length.max(1e-6)).clamp(0.0, 1.0);
        if start > 0.0 { light * Vec3::ONE.lerp(passed, share) } else { light }
    })
}

impl CurveMap {
    /// Number of texels.
    pub fn texel_count(&self) -> usize {
        self.packed.len() / self.nodes.max(1)
    }

    pub(in crate::reference) fn nodes_of(&self, texel: usize) -> &[PackedNode] {
        &self.packed[texel * self.nodes..][..self.nodes]
    }

    /// Light that reaches light depth `z` of texel number `texel`.
    pub fn light_at(&self, texel: usize, z: f32) -> Vec3 {
        light_at(self.nodes_of(texel), z, self.gain)
    }

    /// Ramps of a texel, by their start: start and end [light depth], and the light behind, which is the product of what
    /// the ramps up to it pass.
    pub fn ramps(&self, texel: usize) -> impl Iterator<Item = (f32, f32, Vec3)> {
        let nodes = self.nodes_of(texel).iter().map(|&node| unpack(node, self.gain));
        let mut used: Vec<_> = nodes.filter(|&(start, ..)| start > 0.0).collect();
        used.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut light = Vec3::ONE;
        used.into_iter().map(move |(start, length, passed)| {
            light *= passed;
            (start / DEPTHS, (start + length) / DEPTHS, light)
        })
    }
}
