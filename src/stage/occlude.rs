//! occlude: opaque, cutout and dithered casters to the opaque depth, by a minimum instead of a clip.
//!
//! In: tiles or segments of `pairs`, `footprints`. Out: `opaques` of tiles that one workgroup
//! finishes; nearness sums of the others.
use super::{
    features::{Features, Flags},
    project::CHUNK_SIZE,
    resolve,
    walk::{self, INVOCATION_ROWS, WalkKernels},
};
use crate::gpu::{Choice, KernelDesc};

pub(super) const DEPTH: Choice = Choice::new("accumulator", "accumulator/depth.wgsl");
/// State for opaque triangles only.
const TRIANGLES: Choice = Choice::new("accumulator", "accumulator/triangles.wgsl");
const TRIANGLE_LANE_CASTER: Choice = Choice::new("lane_caster", "accumulator/triangles.wgsl");
pub(super) const DEPTHS: Choice = Choice::new("output", "accumulator/depths.wgsl");

/// Opaque triangles of a few texels, written straight to `small_depths`, one element per texel of the batch:
/// view by view, row by row.
pub const SMALL: KernelDesc = KernelDesc {
    constants: &[("WORKGROUP_SIZE", CHUNK_SIZE as f64)],
    ..KernelDesc::new("occlude_small", "entry/small.wgsl")
};

/// Opaque depths of tiles that are one segment.
pub const TILES: KernelDesc = walk::tiles("occlude_tiles", &[DEPTH, INVOCATION_ROWS, DEPTHS]);

/// Tiles of opaque triangles only.
pub const TRIANGLE_TILES: KernelDesc =
    walk::tiles("occlude_triangle_tiles", &[TRIANGLES, DEPTHS, TRIANGLE_LANE_CASTER]);

/// Opaque depths of segments of longer tiles.
pub const SEGMENTS: KernelDesc =
    walk::segments("occlude_segments", &[DEPTH, INVOCATION_ROWS, DEPTHS]);

/// Casters whose pairs did not fit.
pub const OVERFLOW: KernelDesc = walk::overflow("occlude_overflow", &[DEPTHS]);

/// Kernels for casters that block light.
pub fn kernels(features: Features) -> WalkKernels {
    WalkKernels {
        tiles: if features.has(Flags::NOT_SOLID) { &TILES } else { &TRIANGLE_TILES },
        segments: &SEGMENTS,
        overflow: &OVERFLOW,
        resolve: &resolve::OPAQUE,
    }
}
