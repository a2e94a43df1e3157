//! Extent of a group's triangles.
use crate::{
    model::{Bounds, Material, Transfer, Triangle},
    records::GpuView,
};

/// Largest side of a small triangle's bounding square \[texels\].
pub const SMALL_SIDE: f32 = 22.0;

/// Extent of a chunk's triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleExtent {
    /// Bounding box, world space \[m\].
    pub bounds: Bounds,
    /// Longest edge \[m\].
    pub longest: f32,
    /// Whether all have the `opaque` transfer.
    pub opaque: bool,
    /// Whether some belong to a volume, whose back faces matter beyond the far plane too.
    pub volume: bool,
}

impl TriangleExtent {
    pub(in crate::shadows) fn of<'a>(
        triangles: impl Iterator<Item = &'a Triangle>,
        materials: &[Material],
    ) -> Self {
        let none = Self { bounds: Bounds::EMPTY, longest: 0.0, opaque: true, volume: false };
        triangles.fold(none, |extent, triangle| {
            let [a, b, c] = triangle.positions;
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let bounds = [a, b, c].iter().fold(extent.bounds, |all, &p| all.with_sphere(p, 0.0));
            let material = &materials[triangle.material as usize];
            Self {
                bounds,
                longest: extent.longest.max(longest),
                opaque: extent.opaque && material.transfer == Transfer::Opaque,
                volume: extent.volume || material.is_volume(),
            }
        })
    }

    /// Whether every triangle is opaque, wholly beyond the near plane and small in the view.
    pub(in crate::shadows) fn is_small(&self, view: &GpuView) -> bool {
        if !self.opaque {
            return false;
        }
        if view.perspective == 0.0 {
            return self.longest * view.scale <= SMALL_SIDE;
        }
        let center = -view.view_from_world.transform_point3(self.bounds.center()).z;
        let nearest = center - self.bounds.radius() * 1.001;
        // A step of 1 m changes x / z by at most (1 + |x / z|) / z.
        let steepest = view.size.length() * 0.5 / view.scale;
        nearest > view.near && self.longest * view.scale * (1.0 + steepest) / nearest <= SMALL_SIDE
    }
}
