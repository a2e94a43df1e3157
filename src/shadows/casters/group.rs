//! A group of casters and its extent.
use super::TriangleExtent;
use crate::shadows::cull::{CasterReach, TileLoadBound};
use crate::{
    model::{Bounds, Class, Material, Shape, Triangle},
    records::{CasterRecord, DIAGONAL, GpuView},
};
use glam::Vec3;
use std::ops::Range;

/// A run of casters in upload order, at most [`crate::stage::project::CHUNK_SIZE`].
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Class of its casters.
    pub class: Class,
    /// Records of its casters.
    pub casters: Range<u32>,
    /// Box around its casters.
    pub extent: Extent,
    /// Extent of its triangles; `None` for particles and Gaussians.
    pub triangles: Option<TriangleExtent>,
    /// Whether its casters are Gaussians.
    pub gaussians: bool,
    /// Generation of its last change.
    pub(in crate::shadows) changed_at: u64,
}

/// Kind of a group's casters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::shadows) enum CasterKind {
    Gaussians,
    Particles,
    Triangles,
}

/// Largest reach of a Gaussian beyond its box: the smallest deviation of `project` times the farthest reach
/// \[texels\].
pub(in crate::shadows) const GAUSSIAN_ENLARGED: f32 = 6.0;

/// Extent of a group's casters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Bounding box, world space \[m\]; NaN if a caster has a number that is infinite or NaN.
    pub bounds: Bounds,
    /// Smallest radius \[m\].
    pub min_radius: f32,
    /// Halves of the longest sides of boxes around single casters.
    pub reach: CasterReach,
}

impl Group {
    /// Adds the group to the casters that may touch the tiles of a view.
    pub(in crate::shadows) fn count_in(&self, load: &mut TileLoadBound) {
        let wherever = Bounds { min: Vec3::NAN, max: Vec3::NAN };
        let around = if self.is_volume() { wherever } else { self.extent.bounds };
        let enlarged = if self.gaussians { GAUSSIAN_ENLARGED } else { 1.0 };
        load.add(&around, self.casters.len() as u32, self.extent.reach, enlarged);
    }

    /// Whether the group has triangles of a volume, which may be listed for any view and tile.
    pub(super) fn is_volume(&self) -> bool {
        self.triangles.is_some_and(|extent| extent.volume)
    }
}

impl Extent {
    /// Extent of spheres.
    pub(super) fn of(spheres: impl IntoIterator<Item = (Vec3, f32)>) -> Self {
        let mut extent = Self {
            bounds: Bounds::EMPTY,
            min_radius: f32::INFINITY,
            reach: CasterReach::default(),
        };
        for (center, radius) in spheres {
            if !(center.is_finite() && radius.is_finite()) {
                let bounds = Bounds { min: Vec3::NAN, max: Vec3::NAN };
                return Self { bounds, min_radius: 0.0, reach: CasterReach::all(f32::NAN, 0) };
            }
            extent.bounds = extent.bounds.with_sphere(center, radius);
            extent.min_radius = extent.min_radius.min(radius);
            extent.reach.add(radius);
        }
        extent
    }

    /// Whether some particle may be at most 2x2 texels in the view: then its radius is below 1.5.
    pub(in crate::shadows) fn may_be_tiny(&self, view: &GpuView) -> bool {
        let texels_per_metre = if view.perspective > 0.0 {
            let center = -view.view_from_world.transform_point3(self.bounds.center()).z;
            let farthest = (center + self.bounds.radius()).min(view.far);
            view.scale / farthest.max(view.near)
        } else {
            view.scale
        };
        self.min_radius * texels_per_metre < 1.5
    }
}

/// Casters from which groups are formed.
#[derive(Clone, Copy)]
pub(in crate::shadows) struct Members<'a> {
    /// Particles in upload order.
    pub casters: &'a [CasterRecord],
    pub triangles: &'a [Triangle],
    /// Indices of the triangles in upload order.
    pub order: &'a [u32],
    pub materials: &'a [Material],
}

impl Members<'_> {
    pub(super) fn triangle(&self, index: u32) -> &Triangle {
        &self.triangles[self.order[index as usize] as usize]
    }
}

impl Group {
    pub(super) fn of_particles(
        class: Class,
        casters: Range<u32>,
        gaussians: bool,
        members: Members<'_>,
    ) -> Self {
        let (extent, triangles, changed_at) = (Extent::of([]), None, 0);
        Self { class, extent, casters, triangles, gaussians, changed_at }.fitted(members)
    }

    pub(super) fn of_triangles(class: Class, casters: Range<u32>, members: Members<'_>) -> Self {
        let triangles = Some(TriangleExtent::of(std::iter::empty(), members.materials));
        let extent = Extent::of([]);
        Self { class, extent, casters, triangles, gaussians: false, changed_at: 0 }.fitted(members)
    }

    /// A group of emitted particles, without any yet.
    pub(super) fn emitted(class: Class, start: u32) -> Self {
        let extent = Extent::of([]);
        let casters = start..start;
        Self { class, casters, extent, triangles: None, gaussians: false, changed_at: 0 }
    }

    /// Whether it may have plain opaque triangles that cast shadows.
    pub(in crate::shadows) fn may_hide(&self) -> bool {
        self.is_triangles() && (Class::Opaque..=Class::HiddenOpaque).contains(&self.class)
    }

    /// Whether its casters are triangles.
    pub fn is_triangles(&self) -> bool {
        self.triangles.is_some()
    }

    pub(in crate::shadows) fn kind(&self) -> CasterKind {
        match self {
            Self { triangles: Some(_), .. } => CasterKind::Triangles,
            Self { gaussians: true, .. } => CasterKind::Gaussians,
            _ => CasterKind::Particles,
        }
    }

    /// Refits the group after its casters have changed.
    pub(in crate::shadows) fn refit(&mut self, members: Members<'_>, changed_at: u64) {
        *self = Self { changed_at, ..self.clone().fitted(members) };
    }

    fn fitted(mut self, members: Members<'_>) -> Self {
        let casters = self.casters.clone();
        if let Some(of_triangles) = &mut self.triangles {
            let triangles = casters.map(|i| members.triangle(i));
            let corners = triangles.clone().flat_map(|triangle| triangle.positions);
            self.extent = Extent::of(corners.map(|corner| (corner, 0.0)));
            *of_triangles = TriangleExtent::of(triangles, members.materials);
            self.extent.reach =
                CasterReach::all(0.5 * of_triangles.longest, self.casters.len() as u32);
        } else {
            let particles = &members.casters[casters.start as usize..casters.end as usize];
            self.extent = Extent::of(particles.iter().map(|caster| {
                let material = &members.materials[caster.material() as usize];
                // Half a quad's diagonal reaches beyond its radius.
                let corner = if material.shape == Shape::Quad { DIAGONAL } else { 1.0 };
                (caster.center, caster.radius * corner)
            }));
        }
        self
    }
}
