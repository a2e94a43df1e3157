//! CPU reference of `wgsl/curve/bodies.wgsl`: bodies, that is puffs and stretches of volumes, in which light
//! falls exponentially.
//!
//! Ramps are linear. While a curve has a free node, its most bent ramp is split in two, with the light at the
//! middle of the body between them; no other node changes. Exact nodes stay exact, and repeated halving
//! approaches the exponential: n equal ramps of a body of transmittance T are off by at most `(1 - T^(1/n))^2
//! / 2`, near the middle of the brightest one.
use super::{MAX_NODES, Node, Streaming};
use glam::Vec3;

/// Least difference between the square roots of the light in front of a body and behind it for which two
/// nodes are worthwhile: a single line is off by half of its square in the middle.
pub const MIN_BEND: f32 = 0.0625;
/// Shortest ramp that is split \[fixed point\].
pub const SHORTEST: u32 = 4;
/// Least square root of light: black counts as 1/2048.
pub const MIN_ROOT: f32 = 0.022_097_087;

impl Streaming {
    /// Splits bodies while more than `spare` nodes are free.
    pub(super) fn split_bodies(&mut self, spare: usize) {
        while self.nodes[spare].span == 0
            && let Some((at, light)) = self.most_bent()
        {
            let whole = self.nodes[at];
            let middle = middle(whole.span);
            self.nodes.copy_within(1..at, 0);
            let front = Node {
                span: whole.span & 0xffff_0000 | middle,
                light: self.encode_light(light),
                ..whole
            };
            self.nodes[at - 1] = front;
            self.nodes[at] = Node { span: middle << 16 | whole.span & 0xffff, ..whole };
        }
    }

    /// Index of the most bent body, and the light in its middle.
    fn most_bent(&self) -> Option<(usize, Vec3)> {
        let mut most = None;
        let (mut bend, mut before) = (MIN_BEND, Vec3::ONE);
        for (i, node) in self.nodes[..self.count].iter().enumerate() {
            let root = self.light_of(node).map(f32::sqrt);
            // No ramp may start in the front half.
            let next = if i + 1 < self.count { self.nodes[i + 1].span >> 16 } else { 0xffff };
            let is_long = node.span & 0xffff >= (node.span >> 16) + SHORTEST;
            let bent = (before - root).abs().max_element();
            if node.is_alone && is_long && next >= middle(node.span) && bent > bend {
                most = Some((i, before * root.max(Vec3::splat(MIN_ROOT))));
                bend = bent;
            }
            before = root;
        }
        most
    }
}

fn middle(span: u32) -> u32 {
    ((span >> 16) + (span & 0xffff) + 1) >> 1
}

const _: () = assert!(MAX_NODES <= 16, "a mask of the kernels has a bit for each node");
