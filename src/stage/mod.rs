//! The pipeline, stage by stage.
//!
//! A kernel is data: its files of `wgsl/`, its bindings and its overrides, joined from lists that
//! kernels share: `hits` (evaluate a hit), `walk` (visit a tile's pairs) and `sums` (add to a
//! texel's sums, or resolve them). Kernels of both tiers are arrays, core first.
pub mod accumulate;
pub mod air;
pub mod bin;
pub mod cluster;
pub mod colored;
pub mod curve;
pub mod filter;
pub mod hits;
pub mod occlude;
pub mod project;
pub mod resolve;
pub mod shade;
pub mod sort;
mod sums;
mod walk;

/// Every kernel: what the layout and shader tests and the export walk.
pub const KERNELS: &[&crate::gpu::KernelDesc] = &[
    &project::PARTICLES,
    &project::TRIANGLES,
    &sort::SERIAL_COUNT,
    &sort::SERIAL_SCAN,
    &sort::SERIAL_SCATTER,
    &sort::WIDE_COUNT,
    &sort::WIDE_SCAN,
    &sort::WIDE_SCATTER,
    &bin::COUNT,
    &bin::SCAN,
    &bin::EMIT,
    &bin::TILES,
    &filter::ROWS,
    &filter::COLUMNS,
    &colored::ROWS,
    &colored::COLUMNS,
    &air::SCATTER,
    &air::SUM,
    &cluster::COUNT,
    &cluster::SCAN,
    &cluster::EMIT,
    &shade::CASTERS_LIT,
    &shade::SEEN[0],
    &shade::SURFACES[0],
    &shade::LAYERS[0],
    &shade::COMPOSITE[0],
    &occlude::SMALL,
    &occlude::TILES[0],
    &occlude::TRIANGLE_TILES[0],
    &occlude::SEGMENTS[0],
    &occlude::OVERFLOW[0],
    &accumulate::TINY[0],
    &accumulate::OVERFLOW[0],
    &accumulate::TILES[0],
    &accumulate::SEGMENTS[0],
    &accumulate::ORDERED[0],
    &accumulate::DISC_TILES[0],
    &accumulate::DISC_SEGMENTS[0],
    &resolve::TILES[0],
    &resolve::ORDERED[0],
    &resolve::OPAQUE[0],
    &colored::TILES[0],
    &colored::SEGMENTS[0],
    &colored::OVERFLOW[0],
    &colored::RESOLVE[0],
    &curve::TILES[0],
    &curve::SEGMENTS[0],
    &curve::DISC_TILES[0],
    &curve::DISC_SEGMENTS[0],
    &curve::RESOLVE[0],
    &occlude::TILES[1],
    &occlude::TRIANGLE_TILES[1],
    &occlude::SEGMENTS[1],
    &occlude::OVERFLOW[1],
    &accumulate::TINY[1],
    &accumulate::OVERFLOW[1],
    &accumulate::TILES[1],
    &accumulate::SEGMENTS[1],
    &accumulate::ORDERED[1],
    &accumulate::DISC_TILES[1],
    &accumulate::DISC_SEGMENTS[1],
    &accumulate::DISC_QUEUE_TILES,
    &accumulate::DISC_QUEUE_SEGMENTS,
    &resolve::TILES[1],
    &resolve::ORDERED[1],
    &resolve::OPAQUE[1],
    &colored::TILES[1],
    &colored::SEGMENTS[1],
    &colored::OVERFLOW[1],
    &colored::RESOLVE[1],
    &curve::TILES[1],
    &curve::SEGMENTS[1],
    &curve::DISC_TILES[1],
    &curve::DISC_SEGMENTS[1],
    &curve::RESOLVE[1],
    &shade::SEEN[1],
    &shade::SURFACES[1],
    &shade::LAYERS[1],
    &shade::COMPOSITE[1],
];
