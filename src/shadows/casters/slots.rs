//! Room for the particles of emitters among the casters.
use crate::{model::emission::Emission, stage::load::group_count};

/// Records that an emitter needs.
#[derive(Clone, Debug, PartialEq)]
pub struct EmittedSlots {
    /// Index of the particles' material.
    pub material: u32,
    /// Groups of [`CHUNK_SIZE`](crate::stage::project::CHUNK_SIZE) records.
    pub group_count: u32,
    /// Least and largest radius \[m\].
    pub radii: [f32; 2],
}

impl EmittedSlots {
    /// Room for the particles of an emitter.
    pub fn of(emission: &Emission) -> Self {
        let emitter = &*emission.emitter;
        let radii = emitter.radius.iter().copied();
        Self {
            material: emitter.material,
            group_count: group_count(emitter.forces.most_until(emitter.steps)),
            radii: [radii.clone().fold(f32::INFINITY, f32::min), radii.fold(0.0, f32::max)],
        }
    }
}
