//! Records of uploaded casters, and the properties that decide their order.
use crate::{
    model::{Class, Gaussian, Material, Particle, Pattern, Transfer},
    records::{CAPSULE_RECORDS, Capsules, Caster, GaussianAxes},
};
use std::ops::Range;

/// Properties of a material that decide where its casters are in the upload.
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

/// Number of particles at the start of one class's indices; Gaussians follow them.
pub(super) fn particles_in(order: &[u32], particle_count: usize) -> usize {
    order.partition_point(|&index| (index as usize) < particle_count)
}

/// A Gaussian's axes, as long as a particle's record.
fn axes_record(gaussian: &Gaussian) -> Caster {
    bytemuck::cast(GaussianAxes::new(gaussian))
}

/// The casters and materials from which records are made.
#[derive(Clone, Copy)]
pub(super) struct RecordSources<'a> {
    /// The last of them stand for the capsules.
    pub particles: &'a [Particle],
    pub capsules: &'a Capsules,
    pub gaussians: &'a [Gaussian],
    pub materials: &'a [Material],
    pub axes_first: u32,
}

impl RecordSources<'_> {
    fn gaussian(&self, index: u32) -> Option<u32> {
        index.checked_sub(self.particles.len() as u32)
    }

    fn capsule(&self, index: u32) -> Option<u32> {
        let first = self.particles.len() - self.capsules.particles.len();
        index.checked_sub(first as u32).filter(|_| self.gaussian(index).is_none())
    }

    /// Records behind the ranks of the blue noise that a caster needs besides its own.
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

    /// All of them.
    pub(super) fn all_behind(&self) -> impl Iterator<Item = Caster> + '_ {
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

    pub(super) fn record(&self, index: u32) -> Caster {
        let material = &self.materials[self.material(index) as usize];
        self.gaussian(index).map_or_else(
            || {
                let caster = Caster::new(&self.particles[index as usize], material);
                let record = self.capsule(index).map(|capsule| self.capsule_record(capsule));
                Caster { id: record.unwrap_or(caster.id), ..caster }
            },
            |gaussian| {
                let axes = self.axes_first + gaussian;
                Caster::of_gaussian(&self.gaussians[gaussian as usize], material, axes)
            },
        )
    }
}
