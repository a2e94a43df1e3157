//! Curves of disjoint casters joined into one: the product of their light at every depth, in as many nodes.
use super::{DEPTHS, Streaming, unpack};
use glam::Vec3;
use gobo::records::PackedNode;

/// The joined curve of a texel, without `gain`. Each part is a curve of `count` nodes; the transmittance of
/// each of their ramps is inserted in order of depth, as hits are. The order of the parts has no effect;
/// beyond the parts' own errors the light is off by at most the loss in one node of the joined curve.
pub fn joined<'a>(parts: impl Iterator<Item = &'a [PackedNode]>, count: usize) -> Vec<PackedNode> {
    let mut ramps = Vec::new();
    for part in parts {
        for &node in part {
            let (start, length, passed) = unpack(node, false);
            if start > 0.0 {
                ramps.push((start, start + length, passed));
            }
        }
    }
    let bits = |&(start, end, share): &(f32, f32, Vec3)| {
        (start.to_bits(), end.to_bits(), share.to_array().map(f32::to_bits))
    };
    ramps.sort_unstable_by_key(bits);
    let mut curve = Streaming::new(count as u32, false);
    for (start, end, share) in ramps {
        curve.insert(start / DEPTHS, end / DEPTHS, share);
    }
    curve.pack().collect()
}
