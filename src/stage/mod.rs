//! The pipeline, stage by stage, in dispatch order.
pub mod accumulate;
pub mod bin;
pub mod filter;
pub mod hits;
pub mod occlude;
pub mod project;
pub mod resolve;
pub mod shade;
pub mod sort;

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
    &bin::RANGES,
    &bin::SEGMENTS,
    &bin::DISPATCH,
    &filter::ROWS,
    &filter::COLUMNS,
    &shade::CASTERS_LIT,
    &shade::SEEN_CORE,
    &shade::SURFACES_CORE,
    &shade::LAYERS_CORE,
    &shade::COMPOSITE_CORE,
    &occlude::TILES_CORE,
    &occlude::SEGMENTS_CORE,
    &occlude::OVERFLOW_CORE,
    &accumulate::TINY_CORE,
    &accumulate::OVERFLOW_CORE,
    &accumulate::TILES_CORE,
    &accumulate::SEGMENTS_CORE,
    &accumulate::DISC_TILES_CORE,
    &accumulate::DISC_SEGMENTS_CORE,
    &resolve::TILES_CORE,
    &resolve::OPAQUE_CORE,
    &occlude::TILES_NATIVE,
    &occlude::SEGMENTS_NATIVE,
    &occlude::OVERFLOW_NATIVE,
    &accumulate::TINY_NATIVE,
    &accumulate::OVERFLOW_NATIVE,
    &accumulate::TILES_NATIVE,
    &accumulate::SEGMENTS_NATIVE,
    &accumulate::DISC_TILES_NATIVE,
    &accumulate::DISC_SEGMENTS_NATIVE,
    &resolve::TILES_NATIVE,
    &resolve::OPAQUE_NATIVE,
    &shade::SEEN_NATIVE,
    &shade::SURFACES_NATIVE,
    &shade::LAYERS_NATIVE,
    &shade::COMPOSITE_NATIVE,
];
