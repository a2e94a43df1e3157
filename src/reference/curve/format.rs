//! Nodes as they are stored in maps. CPU reference of `wgsl/curve/{node,stored,loaded,light}.wgsl`.
use super::{DARKEST_LOG, DEPTHS, LEVELS, OCTAVES};
use crate::{
    records::{CurveMap, PackedNode},
    reference::resolve::BLACK,
};
use glam::Vec3;

pub(super) fn stored_channel(light: f32, gain: bool) -> u32 {
    if gain {
        let octave = (light.max(1e-9).log2() - DARKEST_LOG) / OCTAVES;
        return (octave * LEVELS).clamp(0.0, LEVELS).round_ties_even() as u32;
    }
    let light = if light < BLACK { 0.0 } else { light };
    (light * LEVELS).round_ties_even() as u32
}

/// Packs `start` and `length` in fixed point, and the light behind.
pub(in crate::reference) fn packed(start: u32, length: f32, light: Vec3, gain: bool) -> PackedNode {
    let root = ((length.max(0.0) / DEPTHS).sqrt() * LEVELS).round_ties_even() as u32;
    let stored = |v| stored_channel(v, gain);
    let (r, g, b) = (stored(light.x), stored(light.y), stored(light.z));
    [start << 16 | root << 4 | r >> 8, (r & 255) << 24 | g << 12 | b]
}

/// Start and length in fixed point, and the light behind.
pub(in crate::reference) fn unpack([first, second]: PackedNode, gain: bool) -> (f32, f32, Vec3) {
    let root = (first >> 4 & 0xfff) as f32 / LEVELS;
    let loaded = |v| loaded_channel(v, gain);
    let red = (first & 15) << 8 | second >> 24;
    let light = Vec3::new(loaded(red), loaded(second >> 12 & 0xfff), loaded(second & 0xfff));
    ((first >> 16) as f32, root * root * DEPTHS, light)
}

/// Light at light depth `z` of a curve; `gain` as it was packed. Overlapping ramps multiply.
pub fn light_at(nodes: &[PackedNode], z: f32, gain: bool) -> Vec3 {
    let z = z * DEPTHS;
    // Light behind the last node that starts before z, light at z, and transmittance of earlier nodes from
    // z on.
    let (mut behind, mut here, mut rest) = (Vec3::ONE, Vec3::ONE, Vec3::ONE);
    for &node in nodes {
        let (start, length, light) = unpack(node, gain);
        if start > 0.0 && start < z {
            rest *= Vec3::select(behind.cmpgt(Vec3::ZERO), here / behind, Vec3::ONE);
            let share = ((z - start) / length.max(1e-6)).clamp(0.0, 1.0);
            here = behind + (light - behind) * share;
            behind = light;
        }
    }
    rest * here
}

fn loaded_channel(bits: u32, gain: bool) -> f32 {
    let share = bits as f32 / LEVELS;
    match (gain, bits) {
        (true, 0) => 0.0,
        (true, _) => (share * OCTAVES + DARKEST_LOG).exp2(),
        (false, _) => share,
    }
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

    /// Ramps of a texel, nearest first: start and end [light depth], and the light behind.
    pub fn ramps(&self, texel: usize) -> impl Iterator<Item = (f32, f32, Vec3)> {
        let ramps = self.nodes_of(texel).iter().map(|&node| unpack(node, self.gain));
        let used = ramps.filter(|&(start, ..)| start > 0.0);
        used.map(|(start, length, light)| (start / DEPTHS, (start + length) / DEPTHS, light))
    }
}
