//! colored: coloured dithering. Each channel of a dithered caster has its own threshold and its own opaque
//! depth, so that three depths hold coloured layers in any order (McGuire and Enderton 2011). Replaces
//! `occlude`.
//!
//! In: the inputs of `occlude`. Out: `colored`, the opaque depth per channel; `opaques`, the largest of the
//! three, behind which there is no light. Softened: maps without `colored`.
use super::walk::{self, INVOCATION_ROWS, WalkKernels};
use crate::gpu::{Choice, KernelDesc};

const COLORED: Choice = Choice::new("accumulator", "accumulator/colored.wgsl");
const COLORED_DEPTHS: Choice = Choice::new("output", "accumulator/colored.wgsl");

/// Depths per channel of tiles that are one segment.
pub const TILES: KernelDesc =
    walk::tiles("colored_tiles", &[COLORED, INVOCATION_ROWS, COLORED_DEPTHS]);

/// Depths per channel of segments of longer tiles.
pub const SEGMENTS: KernelDesc =
    walk::segments("colored_segments", &[COLORED, INVOCATION_ROWS, COLORED_DEPTHS]);

/// Casters whose pairs did not fit.
pub const OVERFLOW: KernelDesc = walk::overflow("colored_overflow", &[COLORED_DEPTHS]);

/// Tiles of several segments.
pub const RESOLVE: KernelDesc =
    walk::resolve("colored_resolve", &[COLORED, INVOCATION_ROWS, COLORED_DEPTHS]);

/// Kernels for casters that block light, with coloured dithering.
pub const KERNELS: WalkKernels =
    WalkKernels { tiles: &TILES, segments: &SEGMENTS, overflow: &OVERFLOW, resolve: &RESOLVE };
