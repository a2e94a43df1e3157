//! Kernels for llvmpipe alone: `wgsl/llvmpipe/`, chosen by [`Tuning`](super::tuning::Tuning). Without
//! them, and without `queued`, `interleaved`, `columns` and `loaded`, only speed is lost.
use super::{
    accumulate::{DISCS, MAPS, PLAIN, SPLATS},
    curve,
    features::Simple,
    walk,
};
use crate::gpu::{Choice, KernelDesc, SAMPLED, Tier, UNROLLED};

/// Replaces [`IN_ORDER`](super::walk::IN_ORDER).
pub(super) const INTERLEAVED: Choice = Choice::new("order", "llvmpipe/choices.wgsl");
/// Reads sampled textures as storage textures where `wgsl/bind/loaded.wgsl` declares them, as many as the
/// tier allows.
pub const LOADED: Choice = Choice::new(SAMPLED, "bind/loaded.wgsl");
/// Workgroups walk runs of tiles.
pub const RUNS: Choice = Choice::new("tiles", "llvmpipe/choices.wgsl");
/// Invocations hold four texels in a column, or eight of simple casters; nodes of curves and hits that wait
/// for late ones are in registers, and loops over them are unrolled.
pub const COLUMNS: [Choice; 6] = [
    Choice::new("rows", "llvmpipe/choices.wgsl"),
    Choice::new("nodes", "llvmpipe/nodes.wgsl"),
    Choice::new("written", "llvmpipe/choices.wgsl"),
    Choice::new("waiting", "llvmpipe/nodes.wgsl"),
    EIGHT,
    WRITTEN_OUT,
];
/// Invocations hold eight texels of casters of one simple kind.
const EIGHT: Choice = Choice::new("column", "llvmpipe/choices.wgsl");
/// All marked loops are unrolled.
const WRITTEN_OUT: Choice = Choice::new(UNROLLED, "features.wgsl");
/// Collects casters until there is one for each lane.
const QUEUE: Choice = Choice::new("traversal", "llvmpipe/queue.wgsl");
/// Prefetches maps before they are written.
const FETCHED: Choice = Choice::new("maps", "llvmpipe/choices.wgsl");

/// Replaces [`DISC_TILES`](super::accumulate::DISC_TILES) where discs are collected in a queue.
pub const DISC_QUEUE_TILES: KernelDesc = KernelDesc {
    tiers: &[Tier::Native],
    ..walk::tiles(
        "accumulate_disc_queue_tiles",
        &[INTERLEAVED, PLAIN, EIGHT, DISCS, MAPS, FETCHED, QUEUE],
    )
};

/// Replaces [`DISC_SEGMENTS`](super::accumulate::DISC_SEGMENTS) where discs are collected in a queue.
pub const DISC_QUEUE_SEGMENTS: KernelDesc = KernelDesc {
    tiers: &[Tier::Native],
    ..walk::segments("accumulate_disc_queue_segments", &[PLAIN, EIGHT, DISCS, MAPS, QUEUE])
};

/// Replaces [`SPLAT_TILES`](super::accumulate::SPLAT_TILES) where splats are collected in a queue.
pub const SPLAT_QUEUE_TILES: KernelDesc = KernelDesc {
    name: "accumulate_splat_queue_tiles",
    with: &[INTERLEAVED, PLAIN, EIGHT, SPLATS, MAPS, FETCHED, QUEUE],
    ..DISC_QUEUE_TILES
};

/// The same for segments.
pub const SPLAT_QUEUE_SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_splat_queue_segments",
    with: &[PLAIN, EIGHT, SPLATS, MAPS, QUEUE],
    ..DISC_QUEUE_SEGMENTS
};

/// Collects discs for curves by two walks.
const CURVE_RAYS: Choice = Choice::new("accumulator", "llvmpipe/curve_texels.wgsl");
/// Prefetches maps and curves before they are written.
const CURVES_FETCHED: Choice = Choice::new("maps", "llvmpipe/curves_fetched.wgsl");
const CURVE_QUEUE: Choice = Choice::new("traversal", "llvmpipe/curve_queue.wgsl");

/// Replaces [`curve::DISC_TILES`] where discs are collected in a queue.
pub const CURVE_QUEUE_TILES: KernelDesc = KernelDesc {
    constants: &[("NODES", 8.0)],
    tiers: &[Tier::Native],
    ..walk::tiles(
        "accumulate_curve_queue_tiles",
        &[INTERLEAVED, CURVE_RAYS, EIGHT, DISCS, curve::RAY_TILE, CURVES_FETCHED, CURVE_QUEUE],
    )
};

/// Replaces [`curve::DISC_SEGMENTS`] where discs are collected in a queue.
pub const CURVE_QUEUE_SEGMENTS: KernelDesc = KernelDesc {
    constants: &[("NODES", 8.0)],
    tiers: &[Tier::Native],
    ..walk::segments(
        "accumulate_curve_queue_segments",
        &[CURVE_RAYS, EIGHT, DISCS, curve::RAY_SEGMENT, CURVE_QUEUE],
    )
};

/// Kernels for tiles and segments that collect casters of a kind.
pub(super) fn queue_kernels(kind: Simple) -> [&'static KernelDesc; 2] {
    match kind {
        Simple::Discs => [&DISC_QUEUE_TILES, &DISC_QUEUE_SEGMENTS],
        Simple::Splats => [&SPLAT_QUEUE_TILES, &SPLAT_QUEUE_SEGMENTS],
    }
}
