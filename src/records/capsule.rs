//! Capsules of strands as kernels read them.
use super::CasterRecord;
use crate::model::{Capsule, Particle, Strand};
use glam::Vec3;
use std::borrow::Cow;

/// Records of particles that a [`CapsuleRecord`] replaces.
pub const CAPSULE_RECORDS: u32 = 2;

crate::records::texel_struct! {
    /// A segment of a strand, behind the particles and Gaussians in `casters`.
    pub struct CapsuleRecord {
        /// First end, world space \[m\].
        pub first: Vec3,
        /// Radius there \[m\].
        pub first_radius: f32,
        /// Unit normal of the plane through it; both normals point from the first end to the last.
        pub first_plane: Vec3,
        /// Seed of dither patterns: the strand's, at the offset of a particle's.
        pub id: u32,
        /// Last end, world space \[m\].
        pub last: Vec3,
        /// Radius there \[m\].
        pub last_radius: f32,
        /// Unit normal of the plane through it.
        pub last_plane: Vec3,
        pub unused: u32,
    }
}

impl CapsuleRecord {
    /// The record of a capsule; `id`: its strand's.
    pub fn new(capsule: &Capsule, id: u32) -> Self {
        let [first, last] = capsule.ends;
        let [first_radius, last_radius] = capsule.radii;
        let [first_plane, last_plane] = capsule.planes;
        let unused = 0;
        Self { first, first_radius, first_plane, id, last, last_radius, last_plane, unused }
    }
}

/// All capsules of a scene: their records, and the particles that stand for them in the lists of casters.
#[derive(Clone, Debug, Default)]
pub struct Capsules {
    /// Records of all capsules.
    pub records: Vec<CapsuleRecord>,
    /// The sphere around each, with its index as id.
    pub particles: Vec<Particle>,
}

impl Capsules {
    /// The capsules of strands.
    pub fn new(strands: &[Strand]) -> Self {
        let mut all = Self::default();
        for strand in strands {
            for capsule in strand.capsules() {
                let id = all.records.len() as u32;
                all.records.push(CapsuleRecord::new(&capsule, strand.id));
                all.particles.push(particle(strand.material, &capsule, id));
            }
        }
        all
    }

    /// `particles`, then the capsules.
    pub fn among<'a>(&self, particles: Cow<'a, [Particle]>) -> Cow<'a, [Particle]> {
        if self.particles.is_empty() {
            return particles;
        }
        let mut all = particles.into_owned();
        all.extend_from_slice(&self.particles);
        Cow::Owned(all)
    }

    /// The records as records of particles, [`CAPSULE_RECORDS`] each.
    pub fn as_casters(&self) -> &[CasterRecord] {
        bytemuck::cast_slice(&self.records)
    }
}

/// The sphere around a capsule, as a particle of its material.
fn particle(material: u32, capsule: &Capsule, id: u32) -> Particle {
    let [first, last] = capsule.ends;
    let center = (first + last) * 0.5;
    let reach = capsule.reaches().into_iter().fold(0.0, f32::max);
    // Rounding of the ends.
    let slack = center.abs().max_element() * 4.0 * f32::EPSILON;
    let radius = (first.distance(last) * 0.5 + reach) * 1.0001 + slack;
    Particle { center, radius, color: capsule.color, material, id, rotation: 0.0 }
}
