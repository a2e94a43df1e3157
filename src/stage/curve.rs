//! accumulate and resolve of curve mode: transmittance as a function of depth, per texel.
//!
//! In: tiles or segments of `pairs`, `footprints`, opaque depths, and the sums of casters whose pairs did
//! not fit. Out: `curves`, `filters` and `nearests`; segments of long tiles write `partials`, which
//! `resolve_curve` combines in order.
use super::{
    formula::{
        Formula::{self, Is, Of, Product, Quotient, Sum},
        Number,
    },
    walk::{CANDIDATE, IN_ORDER, SUMS},
};
use crate::{
    gpu::{Choice, KernelDesc, Tier},
    records::CURVE_SEGMENT,
};

/// Size of one segment's record in `partials` [bytes]. WGSL: `wgsl/curve/partial.wgsl`.
pub const PARTIAL_BYTES: Formula = {
    const NODES: Formula = Quotient(&Of(Number::Nodes), &Is(2));
    const MORE: Formula = Product(&Is(5), &Of(Number::Changes));
    const LAYERS: Formula = Sum(&NODES, &Sum(&Is(1), &MORE));
    Product(&Is(16 * 16 * 16), &LAYERS)
};

/// Most segments with partial results: only tiles with more than one segment have them.
pub const PARTIAL_COUNT: Formula = {
    const WHOLE: Formula = Quotient(&Of(Number::PairCapacity), &Is(CURVE_SEGMENT as u64));
    Sum(&Product(&Is(2), &WHOLE), &Is(1))
};

/// Sampled textures where a stage has no more than 4 storage textures: loads from storage textures are far
/// cheaper on software adapters.
const PAIRS: Choice =
    Choice::by_tier("pairs", "curve/pairs_sampled.wgsl", "curve/pairs_loaded.wgsl");
const WALK: Choice = Choice::by_tier("walk", "walk/slabs_uniform.wgsl", "walk/slabs_subgroup.wgsl");
const CURVES: Choice = Choice::new("state", "curve/gather.wgsl");
const HITS: Choice = Choice::new("visit", "curve/visit_hits.wgsl");
/// Visits soft discs of the `filter` transfer only.
const DISCS: Choice = Choice::new("visit", "curve/visit_discs.wgsl");
const DISC_CANDIDATE: Choice = Choice::new("candidate", "curve/visit_discs.wgsl");
/// Visits the nodes of tiles whose segments have curves of their own.
const NODES: Choice = Choice::new("visit", "curve/resolve.wgsl");
const TILE: Choice = Choice::new("store", "curve/tile.wgsl");
const SEGMENT: Choice = Choice::new("store", "curve/segment.wgsl");
const RESOLVED: Choice = Choice::new("store", "curve/resolve.wgsl");

pub const TILES: KernelDesc = KernelDesc {
    name: "accumulate_curve_tiles",
    entry: "walk_tile",
    root: "driver/tile.wgsl",
    with: &[IN_ORDER, CURVES, HITS, TILE, PAIRS, WALK, CANDIDATE, SUMS],
    constants: &[("NODES", 8.0), ("HAS_OVER", 1.0), ("HAS_VOLUMES", 1.0)],
    tiers: Tier::ALL,
};

pub const SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_curve_segments",
    entry: "walk_segment",
    root: "driver/segment.wgsl",
    with: &[CURVES, HITS, SEGMENT, PAIRS, WALK, CANDIDATE],
    constants: &[("NODES", 8.0), ("HAS_OVER", 1.0), ("HAS_VOLUMES", 1.0)],
    tiers: Tier::ALL,
};

pub const DISC_TILES: KernelDesc = KernelDesc {
    name: "accumulate_curve_disc_tiles",
    entry: "walk_tile",
    root: "driver/tile.wgsl",
    with: &[IN_ORDER, CURVES, DISCS, TILE, PAIRS, WALK, DISC_CANDIDATE, SUMS],
    constants: &[("NODES", 8.0)],
    tiers: Tier::ALL,
};

pub const DISC_SEGMENTS: KernelDesc = KernelDesc {
    name: "accumulate_curve_disc_segments",
    entry: "walk_segment",
    root: "driver/segment.wgsl",
    with: &[CURVES, DISCS, SEGMENT, PAIRS, WALK, DISC_CANDIDATE],
    constants: &[("NODES", 8.0)],
    tiers: Tier::ALL,
};

pub const RESOLVE: KernelDesc = KernelDesc {
    name: "resolve_curve",
    entry: "resolve_tile",
    root: "driver/resolve.wgsl",
    with: &[CURVES, NODES, RESOLVED, SUMS],
    constants: &[("NODES", 8.0)],
    tiers: Tier::ALL,
};
