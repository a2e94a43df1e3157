//! The casters of a set in groups: what is culled, listed and kept together.
use super::casters::Class;
use crate::{
    cull::{DOUBLED, Frustum, GroupTree, order, typical_size},
    footprint::{Caster, TriangleRecord},
    scene::Bounds,
    stage::project::CHUNK_SIZE,
    view::GpuView,
};
use glam::{Vec3, Vec4Swizzles as _};
use std::{ops::Range, sync::atomic::AtomicU64};

/// Casters of a group before it may end early.
const LEAST: u32 = 32;
/// Objects that may have groups of their own. With more, small ones share.
const MOST_OBJECTS: usize = 1024;
/// How much larger particles' groups may become before they are formed anew: four times the
/// surface.
const SPREAD: u64 = 2 * DOUBLED;

/// Moments of change, each later than all before it, whichever set they are of.
pub(super) fn now() -> u64 {
    static CLOCK: AtomicU64 = AtomicU64::new(1);
    CLOCK.fetch_add(1, std::sync::atomic::Ordering::Relaxed)
}

/// Casters side by side in the upload, at most [`CHUNK_SIZE`].
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    pub class: Class,
    pub is_triangles: bool,
    pub casters: Range<u32>,
    pub extent: Extent,
    /// When something in it last changed.
    pub(super) changed_at: u64,
}

/// What a group's casters are within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// World space [m]; NaN where a caster has a number that is not finite.
    pub bounds: Bounds,
    /// [m]
    pub min_radius: f32,
}

impl Extent {
    /// Of spheres.
    fn of(spheres: impl IntoIterator<Item = (Vec3, f32)>) -> Self {
        let mut extent = Self { bounds: Bounds::EMPTY, min_radius: f32::INFINITY };
        for (center, radius) in spheres {
            if !(center.is_finite() && radius.is_finite()) {
                return Self { bounds: Bounds { min: Vec3::NAN, max: Vec3::NAN }, min_radius: 0.0 };
            }
            extent.bounds = extent.bounds.with_sphere(center, radius);
            extent.min_radius = extent.min_radius.min(radius);
        }
        extent
    }

    /// Whether some particle may be at most 2x2 texels in the view: then its radius is below 1.5.
    pub(super) fn may_be_tiny(&self, view: &GpuView) -> bool {
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

/// How far a particle reaches: half a quad's diagonal reaches beyond its radius.
pub(super) fn particle_extent(casters: &[Caster], is_quad: &[bool]) -> Extent {
    Extent::of(casters.iter().map(|caster| {
        let corner = if is_quad[caster.material() as usize] { 1.4143 } else { 1.0 };
        (caster.center, caster.radius * corner)
    }))
}

pub(super) fn triangle_extent(triangles: &[TriangleRecord]) -> Extent {
    let corners = triangles.iter().flat_map(|triangle| triangle.positions_u);
    Extent::of(corners.map(|corner| (corner.xyz(), 0.0)))
}

/// All groups of a set: particles by class, then triangles by class.
#[derive(Debug)]
pub(super) struct Groups {
    pub groups: Vec<Group>,
    tree: GroupTree,
    /// When they were formed.
    built_size: u64,
}

impl Groups {
    /// Of casters in the order of the upload. Ranges are of the classes.
    pub(super) fn new(
        casters: &[Caster],
        particle_ranges: &[(Class, Range<u32>)],
        is_quad: &[bool],
        triangles: &[TriangleRecord],
        triangle_ranges: &[(Class, Range<u32>)],
    ) -> Self {
        let changed_at = now();
        let mut groups = Vec::new();
        for (class, range) in particle_ranges {
            let casters = &casters[range.start as usize..range.end as usize];
            let box_of = |i: u32| {
                let caster = &casters[i as usize];
                (Bounds::EMPTY.with_sphere(caster.center, caster.radius), false)
            };
            for group in order::cut(range.len() as u32, box_of, LEAST, CHUNK_SIZE) {
                let members = &casters[group.start as usize..group.end as usize];
                groups.push(Group {
                    class: *class,
                    is_triangles: false,
                    casters: group.start + range.start..group.end + range.start,
                    extent: particle_extent(members, is_quad),
                    changed_at,
                });
            }
        }
        let object_count = triangles.chunk_by(|a, b| a.id == b.id).count();
        for (class, range) in triangle_ranges {
            let triangles = &triangles[range.start as usize..range.end as usize];
            let box_of = |i: u32| {
                let i = i as usize;
                let starts =
                    object_count <= MOST_OBJECTS && i > 0 && triangles[i].id != triangles[i - 1].id;
                (triangle_extent(&triangles[i..=i]).bounds, starts)
            };
            for group in order::cut(range.len() as u32, box_of, LEAST, CHUNK_SIZE) {
                let members = &triangles[group.start as usize..group.end as usize];
                groups.push(Group {
                    class: *class,
                    is_triangles: true,
                    casters: group.start + range.start..group.end + range.start,
                    extent: triangle_extent(members),
                    changed_at,
                });
            }
        }
        let tree = GroupTree::new(&bounds(&groups));
        let mut all = Self { groups, tree, built_size: 0 };
        all.built_size = all.size();
        all
    }

    /// After groups have changed. False where they should be formed anew: their casters have
    /// drifted apart.
    pub(super) fn refit(&mut self) -> bool {
        self.tree.refit(&bounds(&self.groups));
        let count = self.groups.iter().filter(|group| !group.is_triangles).count() as u64;
        self.size() <= self.built_size + count * SPREAD
    }

    fn size(&self) -> u64 {
        let particles = self.groups.iter().filter(|group| !group.is_triangles);
        typical_size(particles.map(|group| group.extent.bounds))
    }

    /// Indices of the groups that a view may see, in order.
    pub(super) fn visible(&self, view: &GpuView) -> Vec<u32> {
        let mut visible = Vec::new();
        self.tree.cull(&Frustum::new(view), &mut visible);
        // In the order of the upload, so that equal depths sort the same whatever the tree is like.
        let mut seen = vec![0_u64; self.groups.len().div_ceil(64)];
        for &group in &visible {
            seen[group as usize / 64] |= 1 << (group % 64);
        }
        visible.clear();
        for (word, &bits) in (0..).zip(&seen) {
            let mut bits = bits;
            while bits != 0 {
                visible.push(word * 64 + bits.trailing_zeros());
                bits &= bits - 1;
            }
        }
        visible
    }
}

fn bounds(groups: &[Group]) -> Vec<Bounds> {
    groups.iter().map(|group| group.extent.bounds).collect()
}

/// Puts the particles of one class, given by index, in an order in which neighbours lie together.
pub(super) fn sort_by_place(particles: &mut [u32], center: impl Fn(u32) -> Vec3) {
    // Fewer make one or two groups in any order.
    const FEW: usize = 2 * LEAST as usize;
    if particles.len() > FEW {
        let centers: Vec<Vec3> = particles.iter().map(|&i| center(i)).collect();
        let sorted: Vec<u32> =
            order::morton(&centers).into_iter().map(|i| particles[i as usize]).collect();
        particles.copy_from_slice(&sorted);
    }
}
