//! accumulate: composes each tile's pairs front to back, in registers.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths. Out: `filters` and `nearests` of tiles that
//! one workgroup finishes; sums of the other tiles, of tiny particles and of overflow.
use super::{
    bin::SEGMENT_LENGTH,
    curve,
    features::{Features, Flags, Simple},
    llvmpipe,
    project::CHUNK_SIZE,
    resolve,
    walk::{self, INVOCATION_ROWS, SUMS, WalkKernels},
};
use crate::{
    gpu::{Choice, KernelDesc, Tier},
    model::TILE_SIZE,
    records::SATURATED,
};

/// Most workgroups of `tiny`, which fill a GPU.
pub const TINY_GROUPS: u32 = 1024;
/// Largest addend of one of its invocations to a texel at a time. WGSL: `wgsl/sums/scatter.wgsl`.
pub const LARGEST_STEP: u32 = 16380;
// All of them may have seen a sum that is not yet saturated.
const _: () =
    assert!(SATURATED as u64 + (TINY_GROUPS * CHUNK_SIZE) as u64 * (LARGEST_STEP as u64) < 1 << 32);

/// Most texels of segments that are composed one by one, of 32 bytes each, for a number of pairs: the default
/// pair budget would need slightly more than a storage binding of 128 MiB holds.
pub fn composed_texels(pair_capacity: u32) -> u64 {
    const TEXELS: u64 = (TILE_SIZE * TILE_SIZE) as u64;
    const MAX_SEGMENTS: u64 = (128 << 20) / 32 / TEXELS;
    let segments = 2 * u64::from(pair_capacity / SEGMENT_LENGTH) + 1;
    segments.min(MAX_SEGMENTS) * TEXELS
}

/// State of the texels of a lane.
pub(super) const FILTER: Choice = Choice::new("accumulator", "accumulator/filter.wgsl");
/// The same for casters of one simple kind: soft discs or splats, of the `filter` transfer.
pub(super) const PLAIN: Choice = Choice::new("accumulator", "accumulator/plain.wgsl");
const PLAIN_LANE_CASTER: Choice = Choice::new("lane_caster", "accumulator/plain.wgsl");
/// Soft discs.
pub(super) const DISCS: Choice = Choice::new("plain", "hit/disc.wgsl");
pub(super) const SPLATS: Choice = Choice::new("plain", "hit/plain_splat.wgsl");
pub(super) const MAPS: Choice = Choice::new("output", "accumulator/maps.wgsl");
/// Replaces [`MAPS`] where segments are composed one by one.
pub(super) const ORDERED_MAPS: Choice = Choice::new("output", "accumulator/ordered.wgsl");
const STORED: Choice = Choice::new("maps", "choices.wgsl");
/// State of the texels of a lane where sums are kept.
pub(super) const SUMMED: Choice = Choice::new("accumulator", "accumulator/summed.wgsl");
pub(super) const KEPT_SUMS: Choice = Choice::new("output", "sums/kept.wgsl");

/// Filters of tiles that are one segment.
pub const TILES: KernelDesc =
    walk::tiles("accumulate_tiles", &[FILTER, INVOCATION_ROWS, MAPS, STORED]);

/// Filters of segments of longer tiles.
pub const SEGMENTS: KernelDesc =
    walk::segments("accumulate_segments", &[FILTER, INVOCATION_ROWS, MAPS]);

/// Replaces [`SEGMENTS`] where segments are composed one by one.
pub const ORDERED: KernelDesc = KernelDesc {
    entry: "walk_ordered_segment",
    root: "entry/ordered_segment.wgsl",
    constants: &[("HAS_OVER", 1.0), ("HAS_VOLUMES", 1.0), ("HAS_OWNERS", 1.0)],
    ..walk::segments("accumulate_ordered", &[FILTER, INVOCATION_ROWS, ORDERED_MAPS])
};

/// Scatters particles of at most 2 x 2 texels.
pub const TINY: KernelDesc = KernelDesc {
    with: &[SUMS],
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    tiers: Tier::BY_ATOMICS,
    ..KernelDesc::new("accumulate_tiny", "entry/small.wgsl")
};

/// Casters whose pairs did not fit.
pub const OVERFLOW: KernelDesc = walk::overflow("accumulate_overflow", &[MAPS]);

/// [`TILES`] of discs alone.
pub const DISC_TILES: KernelDesc =
    walk::tiles("accumulate_disc_tiles", &[PLAIN, DISCS, MAPS, STORED, PLAIN_LANE_CASTER]);

/// [`SEGMENTS`] of discs alone.
pub const DISC_SEGMENTS: KernelDesc =
    walk::segments("accumulate_disc_segments", &[PLAIN, DISCS, MAPS, PLAIN_LANE_CASTER]);

/// [`TILES`] of splats alone.
pub const SPLAT_TILES: KernelDesc = KernelDesc {
    name: "accumulate_splat_tiles",
    with: &[PLAIN, SPLATS, MAPS, STORED, PLAIN_LANE_CASTER],
    ..DISC_TILES
};

/// [`SEGMENTS`] of splats alone.
pub const SPLAT_SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_splat_segments",
    with: &[PLAIN, SPLATS, MAPS, PLAIN_LANE_CASTER],
    ..DISC_SEGMENTS
};

/// Sums of tiles that are one segment.
pub const SUM_TILES: KernelDesc =
    walk::tiles("accumulate_sum_tiles", &[SUMMED, INVOCATION_ROWS, KEPT_SUMS]);

/// Sums of segments of longer tiles.
pub const SUM_SEGMENTS: KernelDesc =
    walk::segments("accumulate_sum_segments", &[SUMMED, INVOCATION_ROWS, KEPT_SUMS]);

/// Kernels for casters whose sums are kept, of any kind but composed ones.
pub const SUM_KERNELS: WalkKernels = WalkKernels {
    tiles: &SUM_TILES,
    segments: &SUM_SEGMENTS,
    overflow: &OVERFLOW,
    resolve: &resolve::SUMS_ALONE,
};

/// Kernels for casters that filter light.
pub fn kernels(features: Features) -> WalkKernels {
    let curves = features.nodes > 0;
    let composed = features.is_composed();
    let queued = features.has(Flags::QUEUED);
    let [tiles, segments] = match (curves, features.simple()) {
        (true, Some(Simple::Discs)) if queued => {
            [&llvmpipe::CURVE_QUEUE_TILES, &llvmpipe::CURVE_QUEUE_SEGMENTS]
        }
        (true, Some(Simple::Discs)) => [&curve::DISC_TILES, &curve::DISC_SEGMENTS],
        (true, _) if features.only_rays() => [&curve::RAY_TILES, &curve::RAY_SEGMENTS],
        (true, _) => [&curve::TILES, &curve::SEGMENTS],
        (false, Some(kind)) if queued => llvmpipe::queue_kernels(kind),
        (false, Some(Simple::Discs)) => [&DISC_TILES, &DISC_SEGMENTS],
        (false, Some(Simple::Splats)) => [&SPLAT_TILES, &SPLAT_SEGMENTS],
        (false, _) if composed => [&TILES, &ORDERED],
        (false, _) => [&TILES, &SEGMENTS],
    };
    WalkKernels {
        tiles,
        segments,
        overflow: &OVERFLOW,
        resolve: match (curves, composed) {
            (true, _) if features.only_rays() => &curve::RAY_RESOLVE,
            (true, _) => &curve::RESOLVE,
            (false, true) => &resolve::ORDERED,
            (false, false) => &resolve::TILES,
        },
    }
}

/// Whether a kernel's casters are all of one simple kind.
pub(super) fn is_plain(desc: &KernelDesc) -> bool {
    desc.choices().any(|it| it.name == PLAIN.name && it.files == PLAIN.files)
}
