//! Groups of a set's casters: the unit of culling, listing and caching.
use super::group::{Extent, GAUSSIAN_ENLARGED, Group, Members};
use crate::shadows::cull::{
    CasterReach, DOUBLED, Frustum, GroupTree, OccluderPolygons, Occluders, TileLoadBound, order,
    typical_size,
};
use crate::{
    model::{Bounds, CLASSES, Class, Transfer, Triangle},
    records::{GpuView, HostGroup},
    stage::{bin::SEGMENT_LENGTH, project::CHUNK_SIZE},
};
use glam::Vec3;
use rayon::prelude::*;
use std::{ops::Range, sync::atomic::AtomicU64};

/// Least number of casters in a group that ends early.
const MIN: u32 = 32;
/// Most objects with groups of their own. With more, small ones share groups.
const MAX_OBJECTS: usize = 1024;
/// Growth of particles' groups at which they are formed anew: four times the surface.
const SPREAD: u64 = 2 * DOUBLED;

/// The next generation number, later than all numbers of every set so far.
pub(in crate::shadows) fn next_generation() -> u64 {
    static CLOCK: AtomicU64 = AtomicU64::new(1);
    CLOCK.fetch_add(1, std::sync::atomic::Ordering::Relaxed)
}

/// All groups of a set: particles by class, then triangles by class.
#[derive(Debug)]
pub(in crate::shadows) struct Groups {
    pub groups: Vec<Group>,
    tree: GroupTree,
    occluders: OccluderPolygons,
    /// Generation of the occluders' last change.
    pub(in crate::shadows) occluders_at: u64,
    /// [`Self::size`] when the groups were formed.
    built_size: u64,
    /// Groups of each emitter.
    emitted: Vec<Range<usize>>,
    /// First record of emitted particles.
    first_emitted: u32,
}

impl Groups {
    /// Forms the groups. Ranges are those of the classes in the upload, of particles (`false`) and of
    /// Gaussians (`true`). `emitted`: class and records of each emitter, whose groups are empty until
    /// [`Self::place_emitted`].
    pub(in crate::shadows) fn new(
        members: Members<'_>,
        particle_ranges: &[(Class, Range<u32>, bool)],
        triangle_ranges: &[Range<u32>; CLASSES],
        emitted: &[(Class, Range<u32>)],
    ) -> Self {
        let shift = |group: Range<u32>, by: u32| group.start + by..group.end + by;
        let mut groups = Vec::new();
        let mut of_emitters = vec![0..0; emitted.len()];
        for &(class, Range { start, end }, gaussians) in particle_ranges {
            let box_of = |i: u32| {
                let caster = &members.casters[(start + i) as usize];
                (Bounds::EMPTY.with_sphere(caster.center, caster.radius), false)
            };
            let cut = order::cut(end - start, box_of, MIN, CHUNK_SIZE);
            let group = |group| Group::of_particles(class, shift(group, start), gaussians, members);
            groups.par_extend(cut.into_par_iter().map(group));
            let of_class = emitted
                .iter()
                .zip(&mut of_emitters)
                .filter(|((of, _), _)| *of == class && !gaussians);
            for ((_, records), groups_of_emitter) in of_class {
                let first = groups.len();
                let starts = records.clone().step_by(CHUNK_SIZE as usize);
                groups.extend(starts.map(|start| Group::emitted(class, start)));
                *groups_of_emitter = first..groups.len();
            }
        }
        let few_objects = members.triangles.chunk_by(|a, b| a.id == b.id).count() <= MAX_OBJECTS;
        for (class, &Range { start, end }) in Class::ALL.into_iter().zip(triangle_ranges) {
            let box_of = |i: u32| {
                let triangle = members.triangle(start + i);
                let corners = triangle.positions.iter();
                let bounds = corners.fold(Bounds::EMPTY, |b, &p| b.with_sphere(p, 0.0));
                let starts = i > 0 && triangle.id != members.triangle(start + i - 1).id;
                (bounds, starts && few_objects)
            };
            let cut = order::cut(end - start, box_of, MIN, CHUNK_SIZE);
            let group = |group| Group::of_triangles(class, shift(group, start), members);
            groups.par_extend(cut.into_par_iter().map(group));
        }
        let changed_at = next_generation();
        for group in &mut groups {
            group.changed_at = changed_at;
        }
        let tree = GroupTree::new(&bounds(&groups));
        let occluders = OccluderPolygons::default();
        let mut all = Self {
            groups,
            tree,
            occluders,
            occluders_at: changed_at,
            built_size: 0,
            emitted: of_emitters,
            first_emitted: emitted
                .iter()
                .map(|(_, records)| records.start)
                .min()
                .unwrap_or(u32::MAX),
        };
        all.built_size = all.size();
        all.find_occluders(members, changed_at);
        all
    }

    /// Finds the occluders again after opaque triangles have changed.
    pub(in crate::shadows) fn find_occluders(&mut self, members: Members<'_>, changed_at: u64) {
        let plain = |triangle: &Triangle| {
            let material = &members.materials[triangle.material as usize];
            // Textures do not matter for opaque triangles.
            let plain = material.transfer == Transfer::Opaque && !material.is_volume();
            plain.then_some(triangle.positions)
        };
        // Triangles of two groups may take different kernels, whose edges need not agree.
        let of_group =
            |group: &Group| group.casters.clone().map(|i| plain(members.triangle(i))).chain([None]);
        let groups = self.groups.iter().filter(|group| group.may_hide());
        self.occluders = OccluderPolygons::new(groups.flat_map(of_group));
        self.occluders_at = changed_at;
    }

    /// Whether it is a group of emitted particles.
    pub(in crate::shadows) fn is_emitted(&self, group: &Group) -> bool {
        !group.is_triangles() && group.casters.start >= self.first_emitted
    }

    /// Places the particles of all emitters, as `load` has found them, emitter by emitter. `radii`: least and
    /// largest radius of each emitter, and growth of its groups' boxes \[m\].
    pub(in crate::shadows) fn place_emitted(
        &mut self,
        found: &[HostGroup],
        radii: &[([f32; 2], f32)],
    ) {
        let changed_at = next_generation();
        let mut found = found.iter();
        for (groups_of_emitter, &([least, largest], more)) in self.emitted.iter().zip(radii) {
            for (group, found) in self.groups[groups_of_emitter.clone()].iter_mut().zip(&mut found)
            {
                let start = group.casters.start;
                group.casters = start..start + found.count;
                group.changed_at = changed_at;
                let bounds = Bounds { min: found.low - more, max: found.high + more };
                let reach = CasterReach::all(largest + more, found.count);
                let extent = Extent { bounds, min_radius: least, reach };
                group.extent = if found.count > 0 { extent } else { Extent::of([]) };
            }
        }
        self.tree = GroupTree::new(&bounds(&self.groups));
    }

    /// Refits the tree after groups have changed. Returns false if the groups should be formed anew, because
    /// their casters have drifted apart.
    pub(in crate::shadows) fn refit(&mut self) -> bool {
        self.tree.refit(&bounds(&self.groups));
        let count = self.uploaded_particles().count() as u64;
        self.size() <= self.built_size + count * SPREAD
    }

    /// The group that contains a triangle of the upload.
    pub(in crate::shadows) fn of_triangle(&self, triangle: u32) -> &Group {
        let first = self.groups.partition_point(|group| !group.is_triangles());
        let groups = &self.groups[first..];
        &groups[groups.partition_point(|group| group.casters.end <= triangle)]
    }

    fn uploaded_particles(&self) -> impl Iterator<Item = &Group> {
        self.groups.iter().filter(|group| !group.is_triangles() && !self.is_emitted(group))
    }

    fn size(&self) -> u64 {
        typical_size(self.uploaded_particles().map(|group| group.extent.bounds))
    }

    pub(in crate::shadows) fn occluders(&self, view: &GpuView) -> Occluders {
        Occluders::new(&self.occluders, view)
    }

    /// Removes the groups that occluders of the same view hide; returns the number of their casters.
    /// `filters`: whether filtering groups may be hidden, too.
    pub(in crate::shadows) fn hide(
        &self,
        visible: &mut Vec<u32>,
        view: &GpuView,
        occluders: &Occluders,
        filters: bool,
    ) -> u64 {
        let group = |index: u32| &self.groups[index as usize];
        let count = |groups: &[u32]| -> u64 {
            groups.iter().map(|&index| group(index).casters.len() as u64).sum()
        };
        if occluders.is_empty() {
            return 0;
        }
        let filtering = |group: &Group| Class::FILTERING.contains(&group.class);
        let listed =
            |group: &Group| Class::BLOCKING.contains(&group.class) || filters && filtering(group);
        let is_hidden = |group: &Group| {
            let around = &group.extent.bounds;
            // Gaussians reach beyond their boxes where they are enlarged.
            let is_judged = !group.is_volume() && !group.gaussians;
            listed(group) && is_judged && occluders.hide(around, group.is_triangles())
        };
        let mut hidden: Vec<u32> =
            visible.iter().copied().filter(|&index| is_hidden(group(index))).collect();
        if hidden.iter().any(|&index| filtering(group(index))) {
            // In a tile with more pairs than a segment holds, hiding would cut the next segment elsewhere,
            // and sums would round differently.
            let mut crowd = TileLoadBound::new(view);
            let seen = visible.iter().map(|&index| group(index));
            seen.filter(|group| filtering(group)).for_each(|group| group.count_in(&mut crowd));
            hidden.retain(|&index| {
                let group = group(index);
                !filtering(group) || crowd.most(&group.extent.bounds) <= SEGMENT_LENGTH
            });
        }
        // Both are sorted.
        let mut next = hidden.iter().peekable();
        visible.retain(|index| next.next_if_eq(&index).is_none());
        count(&hidden)
    }

    /// Indices of the groups that a view may see, in order.
    pub(in crate::shadows) fn visible(&self, view: &GpuView) -> Vec<u32> {
        let mut visible = Vec::new();
        let has_gaussians = self.groups.iter().any(|group| group.gaussians);
        let enlarged = if has_gaussians { GAUSSIAN_ENLARGED } else { 1.0 };
        self.tree.cull(&Frustum::around(view, enlarged.into()), &mut visible);
        // In upload order, so that equal depths sort the same for any tree.
        let mut seen = vec![0_u64; self.groups.len().div_ceil(64)];
        let volumes = (0..).zip(&self.groups).filter(|(_, group)| group.is_volume());
        for group in visible.iter().copied().chain(volumes.map(|(index, _)| index)) {
            seen[group as usize / 64] |= 1_u64 << (group % 64);
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

/// Sorts the particles of one class, given by index, so that neighbours are close in space.
pub(in crate::shadows) fn sort_by_place(particles: &mut [u32], center: impl Fn(u32) -> Vec3) {
    // Fewer particles make one or two groups in any order.
    const FEW: usize = 2 * MIN as usize;
    if particles.len() > FEW {
        let centers: Vec<Vec3> = particles.iter().map(|&i| center(i)).collect();
        let sorted: Vec<u32> =
            order::morton(&centers).into_iter().map(|i| particles[i as usize]).collect();
        particles.copy_from_slice(&sorted);
    }
}
