//! Variants of the kernels that read a list.
use super::Role;
use crate::{
    gpu::KernelDesc,
    stage::{accumulate, bin, curve, features::Features, occlude, project, resolve},
};

/// Property that chooses between variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trait {
    Curves,
    Plain,
    Composed,
    Solid,
}

impl Trait {
    pub const ALL: &'static [Self] = &[Self::Curves, Self::Plain, Self::Composed, Self::Solid];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Curves => "curves",
            Self::Plain => "plain",
            Self::Composed => "composed",
            Self::Solid => "solid",
        }
    }

    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Curves => "the list filters, and `nodes` is not 0",
            Self::Plain => "soft discs of the `filter` transfer without texture, and nothing else",
            Self::Composed => {
                "there are no curves, and the list has `over`, volumes, or receivers that are tinted by \
                 all casters but their own"
            }
            Self::Solid => "opaque triangles without texture or pattern, and nothing else",
        }
    }

    pub(crate) fn holds(self, features: Features) -> bool {
        match self {
            Self::Curves => features.nodes > 0,
            Self::Plain => features.plain,
            Self::Composed => features.is_composed(),
            Self::Solid => features.solid,
        }
    }
}

/// Variants of a kernel: the first whose traits the list has, else `otherwise`.
#[derive(Clone, Copy, Debug)]
pub struct Variants {
    pub special: &'static [(&'static [Trait], &'static KernelDesc)],
    pub otherwise: &'static KernelDesc,
}

impl Variants {
    const fn only(otherwise: &'static KernelDesc) -> Self {
        Self { special: &[], otherwise }
    }
}

const OCCLUDE_TILES: Variants = Variants {
    special: &[(&[Trait::Solid], &occlude::TRIANGLE_TILES)],
    otherwise: &occlude::TILES,
};
const ACCUMULATE_TILES: Variants = Variants {
    special: &[
        (&[Trait::Curves, Trait::Plain], &curve::DISC_TILES),
        (&[Trait::Curves], &curve::TILES),
        (&[Trait::Plain], &accumulate::DISC_TILES),
    ],
    otherwise: &accumulate::TILES,
};
const ACCUMULATE_SEGMENTS: Variants = Variants {
    special: &[
        (&[Trait::Curves, Trait::Plain], &curve::DISC_SEGMENTS),
        (&[Trait::Curves], &curve::SEGMENTS),
        (&[Trait::Plain], &accumulate::DISC_SEGMENTS),
        (&[Trait::Composed], &accumulate::ORDERED),
    ],
    otherwise: &accumulate::SEGMENTS,
};
const RESOLVE_TILES: Variants = Variants {
    special: &[(&[Trait::Curves], &curve::RESOLVE), (&[Trait::Composed], &resolve::ORDERED)],
    otherwise: &resolve::TILES,
};

/// Variants of a kernel for a list that blocks light (without coloured dithering) or filters it.
pub const fn variants(role: Role, filters: bool) -> Variants {
    match role {
        Role::ProjectParticles => Variants::only(&project::PARTICLES),
        Role::ProjectTriangles => Variants::only(&project::TRIANGLES),
        Role::BinCount => Variants::only(&bin::COUNT),
        Role::BinScan => Variants::only(&bin::SCAN),
        Role::BinEmit => Variants::only(&bin::EMIT),
        Role::BinTiles => Variants::only(&bin::TILES),
        // Blocking lists have no tiny particles.
        Role::Tiny => Variants::only(&accumulate::TINY),
        Role::Overflow if filters => Variants::only(&accumulate::OVERFLOW),
        Role::Overflow => Variants::only(&occlude::OVERFLOW),
        Role::Tiles if filters => ACCUMULATE_TILES,
        Role::Tiles => OCCLUDE_TILES,
        Role::Segments if filters => ACCUMULATE_SEGMENTS,
        Role::Segments => Variants::only(&occlude::SEGMENTS),
        Role::Resolve if filters => RESOLVE_TILES,
        Role::Resolve => Variants::only(&resolve::OPAQUE),
    }
}
