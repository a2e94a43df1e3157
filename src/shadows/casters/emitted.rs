//! Particles of emitters: a kernel writes their records behind those of the upload.
use super::EmittedSlots;
use super::{CasterSet, features::add_emitted_features};
use crate::{
    model::{Class, Shape},
    records::{DIAGONAL, HostGroup},
    stage::project::CHUNK_SIZE,
};
use std::ops::{Range, RangeInclusive};

/// Records of an emitter.
#[derive(Clone, Debug)]
pub(super) struct Emitted {
    pub(super) slots: EmittedSlots,
    first_record: u32,
    /// Number of present particles.
    count: u32,
    /// Least alpha of these particles.
    least_alpha: f32,
}

impl Emitted {
    pub(super) fn records(&self) -> Range<u32> {
        self.first_record..self.first_record + self.slots.group_count * CHUNK_SIZE
    }
}

/// Records of all emitters from record `first` on, and the first record after them.
pub(super) fn placed(slots: &[EmittedSlots], first: u32) -> (Vec<Emitted>, u32) {
    let mut end = first;
    let place = |slots: &EmittedSlots| {
        let emitter =
            Emitted { slots: slots.clone(), first_record: end, count: 0, least_alpha: 1.0 };
        end = end.saturating_add(slots.group_count.saturating_mul(CHUNK_SIZE));
        emitter
    };
    (slots.iter().map(place).collect(), end)
}

impl CasterSet {
    /// Records of each emitter.
    pub(in crate::shadows) fn emitted_records(&self) -> impl Iterator<Item = Range<u32>> + '_ {
        self.emitted.iter().map(Emitted::records)
    }

    /// Takes over the particles that `load` has found, emitter by emitter.
    pub(in crate::shadows) fn place_emitted(&mut self, found: &[HostGroup]) {
        let mut rest = found;
        let mut radii = Vec::with_capacity(self.emitted.len());
        for emitter in &mut self.emitted {
            let (groups, others) = rest.split_at(emitter.slots.group_count as usize);
            rest = others;
            emitter.count = groups.iter().map(|group| group.count).sum();
            emitter.least_alpha = groups.iter().map(|group| group.least_alpha).fold(1.0, f32::min);
            let [least, largest] = emitter.slots.radii;
            let is_quad =
                self.uploaded.materials[emitter.slots.material as usize].shape == Shape::Quad;
            let more = if is_quad { largest * (DIAGONAL - 1.0) } else { 0.0 };
            radii.push(([least, largest], more));
        }
        self.groups.place_emitted(found, &radii);
        self.add_emitted_features();
    }

    /// Adds the features of emitted particles to those of the uploaded casters.
    pub(super) fn add_emitted_features(&mut self) {
        let materials = &self.uploaded.materials;
        for emitter in self.emitted.iter().filter(|emitter| emitter.count > 0) {
            let features = &mut self.features;
            add_emitted_features(features, materials, emitter.slots.material, emitter.least_alpha);
        }
    }

    /// Number of emitted particles.
    pub(in crate::shadows) fn emitted_count(&self) -> u64 {
        self.emitted.iter().map(|emitter| u64::from(emitter.count)).sum()
    }

    /// Number of casters of `classes`, without the host's.
    pub(in crate::shadows) fn count(&self, classes: RangeInclusive<Class>) -> usize {
        let is_listed = |emitter: &&Emitted| {
            let material = &self.uploaded.materials[emitter.slots.material as usize];
            classes.contains(&Class::of(material))
        };
        let emitted: usize =
            self.emitted.iter().filter(is_listed).map(|emitter| emitter.count as usize).sum();
        self.span(classes.clone()).count() + emitted
    }
}
