//! The pipeline, stage by stage.
//!
//! A kernel is data ([`KernelDesc`]): the file of its entry point, and the files for its imports from
//! `choice::`. Everything else is in `wgsl/`.
pub mod accumulate;
pub mod bin;
pub mod blur;
pub mod buckets;
pub mod caustics;
pub mod colored;
pub mod curve;
pub mod features;
pub mod import;
pub mod levels;
pub mod light_points;
pub mod llvmpipe;
pub mod load;
pub mod mask;
pub mod occlude;
pub mod project;
pub mod resolve;
pub mod simulate;
pub mod soften;
pub mod sort;
pub mod tuning;
pub mod walk;

pub use walk::WalkKernels;

use crate::gpu::{KernelDesc, Tier};

/// Every kernel of maps and look-ups.
pub const KERNELS: &[&KernelDesc] = &[
    &load::CASTERS,
    &load::GAUSSIANS,
    &load::VOXELS,
    &load::BRICKS,
    &load::CULL_GROUPS,
    &load::CULL_SCAN,
    &load::CULL_LIST,
    &import::DEPTHS,
    &import::MAPS,
    &project::PARTICLES,
    &project::GAUSSIANS,
    &project::TRIANGLES,
    &sort::SERIAL_COUNT,
    &sort::SERIAL_SCAN,
    &sort::SERIAL_SCATTER,
    &sort::LONG_COUNT,
    &sort::LONG_SCATTER,
    &sort::WIDE_COUNT,
    &sort::WIDE_SCAN,
    &sort::WIDE_SCATTER,
    &sort::WIDE_FEW_COUNT,
    &sort::WIDE_FEW_SCATTER,
    &bin::CLEAR,
    &bin::COUNT,
    &bin::WIDE_COUNT,
    &bin::SCAN,
    &bin::EMIT,
    &bin::WIDE_EMIT,
    &bin::TILES,
    &buckets::COUNT,
    &buckets::PLACE,
    &buckets::EMIT,
    &buckets::SORT,
    &bin::PART_COUNT,
    &bin::PART_CLEAR,
    &bin::PART_PLAN,
    &bin::PART_FIRST,
    &bin::PART_NEXT,
    &bin::PART_GATHER,
    &soften::ROWS,
    &soften::COLUMNS,
    &soften::COLORED_ROWS,
    &soften::COLORED_COLUMNS,
    &soften::CURVE_COLUMNS,
    &blur::NEAR_ROWS,
    &blur::NEAR_COLUMNS,
    &blur::ROWS,
    &blur::COLUMNS,
    &blur::CURVE_ROWS,
    &blur::CURVE_COLUMNS,
    &blur::FILTER_MIP,
    &mask::HOST_SURFACES,
    &mask::HALF_HOST_SURFACES,
    &mask::LOOK_UP,
    &mask::AREA_LOOK_UP,
    &mask::BLUR,
    &mask::ENLARGE,
    &levels::FIRST,
    &levels::NEXT,
    &simulate::START,
    &simulate::PARTICLES,
    &simulate::CASTERS,
    &light_points::LIGHT_SHARES,
    &light_points::AREA_LIGHT_SHARES,
    &light_points::THROWN_LIGHT_SHARES,
    &light_points::THROWN_AREA_LIGHT_SHARES,
    &caustics::DEPTHS,
    &caustics::OWNERS,
    &caustics::THROW,
    &caustics::THROW_IN_CUBE,
    &caustics::SOLID_DEPTHS,
    &caustics::SOLID_OWNERS,
    &caustics::BOUNCE,
    &occlude::SMALL,
    &occlude::TILES,
    &occlude::TRIANGLE_TILES,
    &occlude::SEGMENTS,
    &occlude::OVERFLOW,
    &accumulate::TINY,
    &accumulate::OVERFLOW,
    &accumulate::TILES,
    &accumulate::SEGMENTS,
    &accumulate::ORDERED,
    &accumulate::DISC_TILES,
    &accumulate::DISC_SEGMENTS,
    &accumulate::SPLAT_TILES,
    &accumulate::SPLAT_SEGMENTS,
    &accumulate::SUM_TILES,
    &accumulate::SUM_SEGMENTS,
    &llvmpipe::DISC_QUEUE_TILES,
    &llvmpipe::DISC_QUEUE_SEGMENTS,
    &llvmpipe::SPLAT_QUEUE_TILES,
    &llvmpipe::SPLAT_QUEUE_SEGMENTS,
    &llvmpipe::CURVE_QUEUE_TILES,
    &llvmpipe::CURVE_QUEUE_SEGMENTS,
    &resolve::TILES,
    &resolve::ORDERED,
    &resolve::SUMS_ALONE,
    &resolve::OPAQUE,
    &colored::TILES,
    &colored::SEGMENTS,
    &colored::OVERFLOW,
    &colored::RESOLVE,
    &curve::RELEASE_PAGES,
    &curve::GIVE_PAGES,
    &curve::SETTLE_PAGES,
    &curve::TILES,
    &curve::SEGMENTS,
    &curve::RAY_TILES,
    &curve::RAY_SEGMENTS,
    &curve::RAY_RESOLVE,
    &curve::DISC_TILES,
    &curve::DISC_SEGMENTS,
    &curve::RESOLVE,
];

/// Kernels on each of their tiers, core first.
pub fn on_tiers(
    kernels: &[&'static KernelDesc],
) -> impl Iterator<Item = (&'static KernelDesc, Tier)> {
    let on = move |tier| {
        let of_tier = kernels.iter().filter(move |desc| desc.tiers.contains(&tier));
        of_tier.map(move |&desc| (desc, tier))
    };
    Tier::ALL.iter().flat_map(move |&tier| on(tier))
}
