//! Nodes of a list in the format of maps. CPU reference of `wgsl/curve/{node,stored}.wgsl`.
use crate::resolve::BLACK;
use glam::{BVec3, Vec3};
use gobo::records::curve::{LEAST, PackedNode, packed, unpack};

/// Stores nodes in order, given the light behind each: the next node corrects the rounding of the last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Storing {
    /// Light behind the nodes stored so far.
    left: Vec3,
    grows: bool,
}

impl Storing {
    pub(crate) const fn new(grows: bool) -> Self {
        Self { left: Vec3::ONE, grows }
    }

    /// Node from `start`, in fixed point, with `light` behind it. `start` 0: an unused node, which passes all
    /// light.
    pub(crate) fn store(&mut self, start: u32, length: f32, light: Vec3) -> PackedNode {
        let passed = light / self.left.max(Vec3::splat(1e-9));
        let dark = light.cmplt(Vec3::splat(BLACK)) & BVec3::splat(!self.grows);
        let passed = if start > 0 { Vec3::select(dark, Vec3::ZERO, passed) } else { Vec3::ONE };
        let node = packed(start, length, passed, self.grows);
        self.left *= unpack(node, self.grows).2;
        node
    }
}

/// Light behind nodes that the format can express. Where a late hit brightened the light behind it, the nodes
/// before it are too dark; where light grows from black, they keep the least value from which it can.
pub(super) fn storable(light: &mut [Vec3], grows: bool) {
    let least = if grows { LEAST } else { 1.0 };
    let mut rest = Vec3::ZERO;
    for light in light.iter_mut().rev() {
        let own = Vec3::select(light.cmplt(Vec3::splat(BLACK)), Vec3::ZERO, *light);
        *light = own.max(rest * least);
        rest = rest.max(*light);
    }
}
