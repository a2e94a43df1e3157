//! Classes of casters: the lists that a caster is in, by its material.
use crate::model::{Material, Transfer};
use std::ops::{Range, RangeInclusive};

/// The map that a caster writes, and whether the picture shows it. Ordered so that the classes of each list
/// are neighbours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Opaque in the picture, casts nothing.
    ShownOpaque,
    /// Opaque in the picture, writes the opaque depth.
    Opaque,
    /// Writes the opaque depth, not in the picture.
    HiddenOpaque,
    /// Writes the opaque depth; the picture blends it.
    Dithered,
    /// Blended in the picture, casts nothing.
    Shown,
    /// Blended in the picture, writes the filter map.
    Translucent,
    /// Writes the filter map, not in the picture.
    HiddenTranslucent,
    /// Neither casts nor is in the picture.
    Nothing,
}

impl Class {
    pub(crate) const ALL: [Self; CLASSES] = [
        Self::ShownOpaque,
        Self::Opaque,
        Self::HiddenOpaque,
        Self::Dithered,
        Self::Shown,
        Self::Translucent,
        Self::HiddenTranslucent,
        Self::Nothing,
    ];
    /// Classes that block light.
    pub const BLOCKING: RangeInclusive<Self> = Self::Opaque..=Self::Dithered;
    /// Classes that filter light.
    pub const FILTERING: RangeInclusive<Self> = Self::Translucent..=Self::HiddenTranslucent;
    /// Lists of a shadow view: blocking and filtering casters.
    pub const LISTS: [RangeInclusive<Self>; 2] = [Self::BLOCKING, Self::FILTERING];
    /// Classes that the picture shows as opaque.
    pub const SOLID: RangeInclusive<Self> = Self::ShownOpaque..=Self::Opaque;
    /// Classes that the picture blends.
    pub const BLENDED: RangeInclusive<Self> = Self::Dithered..=Self::Translucent;

    /// Class of a material's casters.
    pub fn of(material: &Material) -> Self {
        let casts = material.casts && material.transfer != Transfer::None;
        let blended = material.transfer == Transfer::Dither || !material.transfer.is_opaque();
        match (material.visible, casts, material.transfer.is_opaque(), blended) {
            (false, false, ..) => Self::Nothing,
            (false, true, true, _) => Self::HiddenOpaque,
            (false, true, false, _) => Self::HiddenTranslucent,
            (true, false, _, false) => Self::ShownOpaque,
            (true, false, _, true) => Self::Shown,
            (true, true, true, false) => Self::Opaque,
            (true, true, true, true) => Self::Dithered,
            (true, true, false, _) => Self::Translucent,
        }
    }

    /// Whether it blocks or filters light.
    pub fn casts(self) -> bool {
        Self::BLOCKING.contains(&self) || Self::FILTERING.contains(&self)
    }
}

pub(crate) const CLASSES: usize = 8;

/// Stable order by class, and each class's range in it.
pub(crate) fn by_class(
    classes: &(impl Iterator<Item = Class> + Clone),
) -> (Vec<u32>, [Range<u32>; CLASSES]) {
    let mut order = Vec::new();
    let mut ranges = [const { 0..0 }; CLASSES];
    for (class, range) in Class::ALL.into_iter().zip(&mut ranges) {
        let first = order.len() as u32;
        order.extend((0..).zip(classes.clone()).filter(|&(_, c)| c == class).map(|(i, _)| i));
        *range = first..order.len() as u32;
    }
    (order, ranges)
}
