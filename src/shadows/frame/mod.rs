//! Passes of a list, from casters to maps, as data: their order, workgroup counts and bindings. The library
//! records and allocates from it, and `gobo export` writes it for engines without wgpu.
mod readers;
pub mod resources;
mod uploads;

pub use readers::{Trait, Variants, variants};
pub use uploads::{BatchUploads, ListUploads, Uploads};

use crate::stage::{
    accumulate,
    bin::{self, Dispatch},
    formula::Formula::{self, Is},
    project,
};

/// A kernel of a list, in any of its variants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    ProjectParticles,
    ProjectTriangles,
    Tiny,
    BinCount,
    BinScan,
    BinEmit,
    Overflow,
    BinTiles,
    Tiles,
    Segments,
    Resolve,
}

impl Role {
    pub const fn name(self) -> &'static str {
        match self {
            Self::ProjectParticles => "project_particles",
            Self::ProjectTriangles => "project_triangles",
            Self::Tiny => "tiny",
            Self::BinCount => "bin_count",
            Self::BinScan => "bin_scan",
            Self::BinEmit => "bin_emit",
            Self::Overflow => "overflow",
            Self::BinTiles => "bin_tiles",
            Self::Tiles => "tiles",
            Self::Segments => "segments",
            Self::Resolve => "resolve",
        }
    }
}

/// Steps that are recorded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    Clear,
    Project,
    Tiny,
    Sort,
    Pairs,
    Overflow,
    Tiles,
    Read,
    Resolve,
}

/// Condition of a step. If it is unknown, it may be assumed: the step then has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    Particles,
    Triangles,
    Tiny,
    Listed,
    MayOverflow,
    Merged,
}

impl When {
    pub const ALL: &'static [Self] = &[
        Self::Particles,
        Self::Triangles,
        Self::Tiny,
        Self::Listed,
        Self::MayOverflow,
        Self::Merged,
    ];

    pub const fn name(self) -> &'static str {
        match self {
            Self::Particles => "particles",
            Self::Triangles => "triangles",
            Self::Tiny => "tiny",
            Self::Listed => "listed",
            Self::MayOverflow => "may_overflow",
            Self::Merged => "merged",
        }
    }

    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Particles => "the list has chunks of particles",
            Self::Triangles => "the list has chunks of triangles",
            Self::Tiny => "the list has chunks of particles that may be tiny, and `scatter` is 1",
            Self::Listed => "the list has casters",
            Self::MayOverflow => "the pairs may not fit in `pair_capacity`",
            Self::Merged => {
                "a tile may have more pairs than a segment, or some are scattered and there are no curves"
            }
        }
    }
}

/// Conditions that hold for a list.
#[derive(Clone, Copy, Debug, Default)]
pub struct Conditions(u32);

impl Conditions {
    #[must_use]
    pub fn with(self, when: When, holds: bool) -> Self {
        Self(self.0 | u32::from(holds) << when as u32)
    }

    /// Adds the conditions of the kernels that read the list.
    #[must_use]
    pub(crate) fn with_readers(self, has_segments: bool, tiny: bool, curves: bool) -> Self {
        // Segments of a tile, or its pairs and scattered casters, are merged; tiles of curves read
        // scattered casters themselves.
        let may_scatter = tiny || self.hold(&[When::MayOverflow]);
        self.with(When::Tiny, tiny).with(When::Merged, has_segments || (may_scatter && !curves))
    }

    pub fn hold(self, all: &[When]) -> bool {
        all.iter().all(|&when| self.0 >> when as u32 & 1 == 1)
    }
}

impl SortOf {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Tile => "tile",
        }
    }
}

/// One of the two sorts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SortOf {
    /// Footprints by depth.
    Depth,
    /// Pairs by tile.
    Tile,
}

/// Resource of a binding.
#[derive(Clone, Copy, Debug)]
pub enum ResourceChoice {
    Is(&'static str),
    /// The first of two if the sort has an even number of digits.
    Sorted([&'static str; 2], SortOf),
    /// The first with curves.
    Curves(&'static str, &'static str),
    /// The first if segments are composed one by one.
    Composed(&'static str, &'static str),
}

/// Resources that a list expects to be zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cleared {
    Counters,
    Dispatches,
    ScatteredTiles,
}

impl Cleared {
    pub const fn name(self) -> &'static str {
        match self {
            Self::Counters => "counters",
            Self::Dispatches => "dispatches",
            Self::ScatteredTiles => "scattered_tiles",
        }
    }
}

/// Workgroup counts.
#[derive(Clone, Copy, Debug)]
pub enum Groups {
    Counts([Formula; 3]),
    /// Counts in `dispatches`.
    Indirect(Dispatch),
}

#[derive(Clone, Copy, Debug)]
pub enum Work {
    /// Sets resources to zero.
    Clear(&'static [Cleared]),
    Sort(SortOf),
    Kernel {
        role: Role,
        groups: Groups,
        /// Sources by binding; other bindings have the resource of their name.
        sources: &'static [(&'static str, ResourceChoice)],
    },
}

#[derive(Clone, Copy, Debug)]
pub struct Step {
    pub part: Part,
    pub when: &'static [When],
    pub work: Work,
}

impl Step {
    const fn kernel(
        part: Part,
        when: &'static [When],
        role: Role,
        groups: Groups,
        sources: &'static [(&'static str, ResourceChoice)],
    ) -> Self {
        Self { part, when, work: Work::Kernel { role, groups, sources } }
    }
}

pub const KEYS: [&str; 2] = ["keys_0", "keys_1"];
pub const PAIRS: [&str; 2] = ["pairs_0", "pairs_1"];
const SORTED_KEYS: ResourceChoice = ResourceChoice::Sorted(KEYS, SortOf::Depth);
const SORTED_PAIRS: ResourceChoice = ResourceChoice::Sorted(PAIRS, SortOf::Tile);

/// Bindings of the kernels that read a list.
const READ: &[(&str, ResourceChoice)] =
    &[("pairs", SORTED_PAIRS), ("partials", ResourceChoice::Composed("composed", "partials"))];

/// Steps of each list of a batch; the list that blocks light comes before the one that filters it.
pub const STEPS: &[Step] = &[
    Step {
        part: Part::Clear,
        when: &[],
        work: Work::Clear(&[Cleared::Counters, Cleared::Dispatches, Cleared::ScatteredTiles]),
    },
    Step::kernel(
        Part::Project,
        &[When::Particles],
        Role::ProjectParticles,
        Groups::Counts(project::PARTICLE_GRID),
        &[
            ("keys", ResourceChoice::Is(KEYS[0])),
            ("chunks", ResourceChoice::Is("particle_chunks")),
            ("project_params", ResourceChoice::Is("particle_params")),
        ],
    ),
    Step::kernel(
        Part::Project,
        &[When::Triangles],
        Role::ProjectTriangles,
        Groups::Counts(project::TRIANGLE_GRID),
        &[
            ("keys", ResourceChoice::Is(KEYS[0])),
            ("chunks", ResourceChoice::Is("triangle_chunks")),
            ("project_params", ResourceChoice::Is("triangle_params")),
        ],
    ),
    Step::kernel(
        Part::Tiny,
        &[When::Tiny],
        Role::Tiny,
        Groups::Counts(accumulate::TINY_GRID),
        &[
            ("chunks", ResourceChoice::Is("tiny_chunks")),
            ("project_params", ResourceChoice::Is("tiny_params")),
        ],
    ),
    Step { part: Part::Sort, when: &[When::Listed], work: Work::Sort(SortOf::Depth) },
    Step::kernel(
        Part::Pairs,
        &[When::Listed],
        Role::BinCount,
        Groups::Counts(bin::RUN_GROUPS),
        &[("sorted", SORTED_KEYS)],
    ),
    Step::kernel(
        Part::Pairs,
        &[When::Listed],
        Role::BinScan,
        Groups::Counts([Is(1), Is(1), Is(1)]),
        &[],
    ),
    Step::kernel(
        Part::Pairs,
        &[When::Listed],
        Role::BinEmit,
        Groups::Counts(bin::RUN_GROUPS),
        &[("sorted", SORTED_KEYS), ("pairs", ResourceChoice::Is(PAIRS[0]))],
    ),
    Step::kernel(
        Part::Overflow,
        &[When::Listed, When::MayOverflow],
        Role::Overflow,
        Groups::Indirect(Dispatch::Overflow),
        READ,
    ),
    Step { part: Part::Tiles, when: &[When::Listed], work: Work::Sort(SortOf::Tile) },
    Step::kernel(
        Part::Tiles,
        &[],
        Role::BinTiles,
        Groups::Counts(bin::TILE_GROUPS),
        &[
            ("pairs", SORTED_PAIRS),
            ("scattered_tiles", ResourceChoice::Curves("nothing_scattered", "scattered_tiles")),
        ],
    ),
    Step::kernel(Part::Read, &[], Role::Tiles, Groups::Counts(bin::TILE_GRID), READ),
    Step::kernel(
        Part::Read,
        &[When::Merged],
        Role::Segments,
        Groups::Indirect(Dispatch::Segment),
        READ,
    ),
    Step::kernel(
        Part::Resolve,
        &[When::Merged],
        Role::Resolve,
        Groups::Indirect(Dispatch::Merged),
        READ,
    ),
];
