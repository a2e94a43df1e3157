//! What the kernels choose alike that walk the pairs of a tile or of a segment.
use crate::gpu::Choice;

/// Visits the footprints that may touch an invocation's texels, front to back.
pub(super) const WALK: Choice = Choice::by_tier("walk", "walk/uniform.wgsl", "walk/subgroup.wgsl");
/// Sums of a batch's texels: buffers on the core tier, textures that take atomics on the native one.
pub(super) const SUMS: Choice = Choice::by_tier("sums", "sums/buffers.wgsl", "sums/textures.wgsl");
/// Lanes test and share any caster.
pub(super) const CANDIDATE: Choice = Choice::new("candidate", "walk/candidate.wgsl");
/// A workgroup takes the tile of its number; [`Profile`](super::profile::Profile) may say otherwise.
pub(super) const IN_ORDER: Choice = Choice::new("order", "driver/in_order.wgsl");
