//! Curves on the host, as maps store them: `wgsl/curve/{node,stored,loaded,light}.wgsl`.
//!
//! A node stores the share of light that it passes by itself, so that light at a depth is the product of the
//! nodes in any order.
use glam::Vec3;

/// Fixed-point steps of depths from the near plane to the far one.
pub const DEPTHS: f32 = 65535.0;
/// Steps of a stored channel, and of the square root of a ramp's length.
pub const LEVELS: f32 = 4095.0;
/// Level of 1 in nodes that may amplify.
pub const EVEN: f32 = 2048.0;
/// Levels per octave in nodes that may amplify.
pub const OCTAVE: f32 = 204.8;
/// Least light of such a curve.
pub const LEAST: f32 = 1.0 / 1024.0;

/// A node of a map: start (16 bits), square root of the length (12), and red, green and blue that it passes
/// by itself (12 each). A node that starts at 0 is unused.
pub type PackedNode = [u32; 2];

/// The curves of one view.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveMap {
    /// Nodes of a texel (K).
    pub nodes: usize,
    /// Whether light may increase along a curve (`gain` and `over` casters).
    pub gain: bool,
    /// Nodes of each texel; texels row by row.
    pub packed: Vec<PackedNode>,
}

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

/// Packs `start` and `length` in fixed point, and the light that the node passes.
pub fn packed(start: u32, length: f32, passed: Vec3, grows: bool) -> PackedNode {
    let root = ((length.max(0.0) / DEPTHS).sqrt() * LEVELS).round_ties_even() as u32;
    let stored = |v| stored_channel(v, grows);
    let (r, g, b) = (stored(passed.x), stored(passed.y), stored(passed.z));
    [start << 16 | root << 4 | r >> 8, (r & 255) << 24 | g << 12 | b]
}

/// Start and length in fixed point, and the light that the node passes.
pub fn unpack([first, second]: PackedNode, grows: bool) -> (f32, f32, Vec3) {
    let root = (first >> 4 & 0xfff) as f32 / LEVELS;
    let loaded = |v| loaded_channel(v, grows);
    let red = (first & 15) << 8 | second >> 24;
    let passed = Vec3::new(loaded(red), loaded(second >> 12 & 0xfff), loaded(second & 0xfff));
    ((first >> 16) as f32, root * root * DEPTHS, passed)
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

    /// Nodes of texel `texel`, used or not.
    pub fn nodes_of(&self, texel: usize) -> &[PackedNode] {
        &self.packed[texel * self.nodes..][..self.nodes]
    }

    /// Light that reaches light depth `z` of texel `texel`.
    pub fn light_at(&self, texel: usize, z: f32) -> Vec3 {
        light_at(self.nodes_of(texel), z, self.gain)
    }

    /// Ramps of a texel, by their start: start and end \[light depth\], and the light behind each, the
    /// product of all ramps up to it.
    pub fn ramps(&self, texel: usize) -> impl Iterator<Item = (f32, f32, Vec3)> {
        let mut ramps = Vec::new();
        self.ramps_to(texel, &mut ramps);
        ramps.into_iter()
    }

    /// [`Self::ramps`] in the place of what `ramps` held.
    pub fn ramps_to(&self, texel: usize, ramps: &mut Vec<(f32, f32, Vec3)>) {
        ramps.clear();
        let nodes = self.nodes_of(texel).iter().map(|&node| unpack(node, self.gain));
        ramps.extend(nodes.filter(|&(start, ..)| start > 0.0));
        ramps.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut light = Vec3::ONE;
        for (start, end, passed) in ramps {
            light *= *passed;
            (*start, *end, *passed) = (*start / DEPTHS, (*start + *end) / DEPTHS, light);
        }
    }
}
