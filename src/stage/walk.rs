//! What the kernels choose alike that walk the pairs of a tile or of a segment.
use crate::gpu::Choice;

/// One texel to an invocation.
pub(super) const ROWS_1: Choice = Choice::new("rows", "walk/rows_1.wgsl");
/// Four texels in a column to an invocation.
pub(super) const ROWS_4: Choice = Choice::new("rows", "walk/rows_4.wgsl");
/// Eight texels in a column to an invocation.
pub(super) const ROWS_8: Choice = Choice::new("rows", "walk/rows_8.wgsl");
/// Visits the footprints that may touch an invocation's texels, front to back.
pub(super) const WALK: Choice = Choice::by_tier("walk", "walk/uniform.wgsl", "walk/subgroup.wgsl");
/// Sums of a batch's texels: buffers on the core tier, textures that take atomics on the native one.
pub(super) const SUMS: Choice = Choice::by_tier("sums", "sums/buffers.wgsl", "sums/textures.wgsl");
