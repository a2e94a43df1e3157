//! Records of uploaded casters, and the properties that decide their order.
use super::groups::sort_by_place;
use crate::{
    model::{CLASSES, Casters, Class, Gaussian, Material, Particle, Pattern, Transfer, by_class},
    records::{CAPSULE_RECORDS, Capsules, CasterRecord, GaussianAxes, blue_ranks},
};
use rayon::prelude::*;
use std::ops::Range;

/// Properties of a material that decide the place of its casters in the upload.
pub(super) fn layout(material: &Material) -> (Class, bool, bool) {
    let blue = material.transfer == Transfer::Dither && material.pattern == Pattern::Blue;
    (Class::of(material), material.transfer == Transfer::Over, blue)
}

/// Materials of particles, then of Gaussians.
pub(super) fn materials_of<'a>(
    particles: &'a [Particle],
    gaussians: &'a [Gaussian],
) -> impl Iterator<Item = u32> + Clone + 'a {
    particles.iter().map(|p| p.material).chain(gaussians.iter().map(|g| g.material))
}

/// Indices of particles and Gaussians by class, and each class's range. Within a class, particles stay in the
/// scene's order, followed by Gaussians in theirs, if blending depends on the order; otherwise both are
/// sorted in space.
pub(super) fn particle_order(
    casters: &Casters<'_>,
    classes: &[Class],
) -> (Vec<u32>, [Range<u32>; CLASSES]) {
    let &Casters { particles, gaussians, materials, in_order, .. } = casters;
    let (mut order, ranges) =
        by_class(&materials_of(particles, gaussians).map(|m| classes[m as usize]));
    let is_ordered = |class| {
        let blends = |material| layout(material).1 && Class::of(material) == class;
        in_order || materials.iter().any(blends)
    };
    for (class, range) in Class::ALL.into_iter().zip(&ranges) {
        if !is_ordered(class) {
            let members = &mut order[range.start as usize..range.end as usize];
            let (of_particles, of_gaussians) =
                members.split_at_mut(particles_in(members, particles.len()));
            sort_by_place(of_particles, |i| particles[i as usize].center);
            sort_by_place(of_gaussians, |i| gaussians[i as usize - particles.len()].center);
        }
    }
    (order, ranges)
}

/// The range of each class, cut into particles (`false`) and Gaussians (`true`).
pub(super) fn by_kind(
    ranges: &[Range<u32>; CLASSES],
    order: &[u32],
    particle_count: usize,
) -> Vec<(Class, Range<u32>, bool)> {
    let cut = |(class, &Range { start, end })| {
        let members = &order[start as usize..end as usize];
        let middle = start + particles_in(members, particle_count) as u32;
        [(class, start..middle, false), (class, middle..end, true)]
    };
    Class::ALL.into_iter().zip(ranges).flat_map(cut).collect()
}

/// Number of particles at the start of a class's indices; Gaussians follow them.
fn particles_in(order: &[u32], particle_count: usize) -> usize {
    order.partition_point(|&index| (index as usize) < particle_count)
}

/// A Gaussian's axes, in a record as long as a particle's.
fn axes_record(gaussian: &Gaussian) -> CasterRecord {
    bytemuck::cast(GaussianAxes::new(gaussian))
}

/// The casters and materials from which records are made.
#[derive(Clone, Copy)]
pub(super) struct RecordSources<'a> {
    /// The last particles stand for the capsules.
    pub particles: &'a [Particle],
    pub capsules: &'a Capsules,
    pub gaussians: &'a [Gaussian],
    pub materials: &'a [Material],
    /// Whether some material dithers by blue noise.
    is_blue: bool,
    pub axes_first: u32,
}

impl<'a> RecordSources<'a> {
    pub(super) fn new(casters: &Casters<'a>, capsules: &'a Capsules) -> Self {
        let &Casters { particles, gaussians, materials, .. } = casters;
        let is_blue = materials.iter().any(|material| layout(material).2);
        let mut sources =
            Self { particles, capsules, gaussians, materials, is_blue, axes_first: 0 };
        sources.axes_first = (particles.len() + gaussians.len() + sources.ranks().len()) as u32;
        sources
    }

    /// Ranks of the blue noise, as records behind the particles, because every dithering kernel binds them
    /// already: eight in the last four words of each, which are no floats, and so keep all bits.
    fn ranks(&self) -> Vec<CasterRecord> {
        let record = |eight: &[u16]| {
            let half: [u32; 4] = bytemuck::pod_read_unaligned(bytemuck::cast_slice(eight));
            bytemuck::cast([[0; 4], half])
        };
        let ranks = if self.is_blue { blue_ranks() } else { &[] };
        ranks.chunks_exact(8).map(record).collect()
    }

    /// First record of the blue noise's ranks.
    pub(super) fn blue_first(&self) -> u32 {
        (self.particles.len() + self.gaussians.len()) as u32
    }

    /// All records of an upload in this order.
    pub(super) fn all(&self, order: &[u32]) -> Vec<CasterRecord> {
        let mut records: Vec<CasterRecord> =
            order.par_iter().map(|&index| self.record(index)).collect();
        records.extend(self.ranks());
        records.extend(self.all_behind());
        records
    }

    fn gaussian(&self, index: u32) -> Option<u32> {
        index.checked_sub(self.particles.len() as u32)
    }

    fn capsule(&self, index: u32) -> Option<u32> {
        let first = self.particles.len() - self.capsules.particles.len();
        index.checked_sub(first as u32).filter(|_| self.gaussian(index).is_none())
    }

    /// Further records of a caster, behind the ranks of the blue noise.
    pub(super) fn behind(&self, index: u32) -> Range<usize> {
        let first = self.axes_first as usize;
        if let Some(gaussian) = self.gaussian(index) {
            let axes = first + gaussian as usize;
            return axes..axes + 1;
        }
        self.capsule(index).map_or(0..0, |capsule| {
            let first = self.capsule_record(capsule) as usize;
            first..first + CAPSULE_RECORDS as usize
        })
    }

    /// All records behind the ranks of the blue noise.
    pub(super) fn all_behind(&self) -> impl Iterator<Item = CasterRecord> + '_ {
        let axes = self.gaussians.iter().map(axes_record);
        axes.chain(self.capsules.as_casters().iter().copied())
    }

    fn capsule_record(&self, capsule: u32) -> u32 {
        self.axes_first + self.gaussians.len() as u32 + capsule * CAPSULE_RECORDS
    }

    pub(super) fn material(&self, index: u32) -> u32 {
        self.gaussian(index).map_or_else(
            || self.particles[index as usize].material,
            |gaussian| self.gaussians[gaussian as usize].material,
        )
    }

    pub(super) fn record(&self, index: u32) -> CasterRecord {
        let material = &self.materials[self.material(index) as usize];
        self.gaussian(index).map_or_else(
            || {
                let caster = CasterRecord::new(&self.particles[index as usize], material);
                let record = self.capsule(index).map(|capsule| self.capsule_record(capsule));
                CasterRecord { id: record.unwrap_or(caster.id), ..caster }
            },
            |gaussian| {
                let axes = self.axes_first + gaussian;
                CasterRecord::of_gaussian(&self.gaussians[gaussian as usize], material, axes)
            },
        )
    }
}
